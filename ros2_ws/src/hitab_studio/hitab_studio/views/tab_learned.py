"""The learned behavior: the hierarchy, an automaton, a state's tree, the last state changes."""

from __future__ import annotations

import math
from typing import Any

from hitab_client import Learned
from hitab_core import FLAGS, START, Term, with_numbers
from hitab_studio.field.graph_layout import graph
from hitab_studio.pages.looking_back import path_of, readings_of
from hitab_studio.pages.page import Page
from hitab_studio.pages.tree_rows import tree_rows
from hitab_studio.views.numbers import measured

TRANSITIONS_SHOWN_MAX = 8
"""Maximum number of state changes listed."""

LEVELS_MAX = 6


def context(page: Page) -> dict[str, Any]:
    """Return the variables of the tab's template."""
    levels = _levels(page)
    chosen = (level for level in levels if level["name"] == page.level)
    shown = next(chosen, levels[0] if levels else {"name": "", "label": "", "state": ""})
    behavior = _behavior(page, shown["name"])
    state = page.state or shown["state"] or START
    tree = behavior.transitions.get(state) if behavior is not None else None
    values = _values(page, shown["label"], behavior)
    events = _events(page)
    names = behavior.feature_labels if behavior is not None else ()
    automata = [b.name for b in page.watched.behaviors.values() if b.is_automaton]
    return {
        "levels": levels,
        "level": shown,
        "behavior": behavior,
        "graph": graph(behavior, automata) if behavior and behavior.transitions else None,
        "state": state,
        "stops": list(getattr(page.status, "breakpoints", ())),
        "last": next((e for e in events if _label(e) == shown["label"]), None),
        "rows": tree_rows(tree, names, dict(zip(names, values, strict=False))) if tree else [],
        "live": bool(values),
        "numbers": _numbers(behavior, state, values),
        "changes": events[:TRANSITIONS_SHOWN_MAX],
        "because": lambda event: _because(page, event),
        "label": _label,
    }


def _behavior(page: Page, name: str) -> Learned | None:
    training = page.training
    if training is not None and training.name == name and page.is_training:
        return training
    return page.watched.behaviors.get(name)


def _levels(page: Page) -> list[dict[str, Any]]:
    """Return the automata of the agent's behavior, active or not, outermost first.

    An active automaton is labeled as in the path of active states, such as ``GoTo(ball)``.
    """
    status, training = page.status, page.training
    if status is None:
        return []
    top = status.behavior or (training.name if training is not None else page.behavior)
    path = list(path_of(page))
    found: dict[str, dict[str, Any]] = {}

    def visit(label: str, depth: int, *, active: bool) -> None:
        name = Term.parse(label).name
        behavior = _behavior(page, name)
        if name in found or behavior is None or not behavior.is_automaton or depth > LEVELS_MAX:
            return
        state = path[depth] if active and depth < len(path) else ""
        found[name] = {"name": name, "label": label, "depth": depth, "state": state}
        for inner in behavior.possible_states:
            if Term.parse(inner).name not in FLAGS:
                visit(inner, depth + 1, active=active and inner == state)

    if top:
        visit(top, 0, active=True)
    return list(found.values())


def _values(page: Page, label: str, behavior: Learned | None) -> list[float]:
    """Return the present values of the automaton's features; [] if unknown."""
    if behavior is None or page.player is not None:
        return []
    values = [
        values[-1]
        for (automaton, _), values in list(readings_of(page).items())
        if automaton == label and values
    ]
    if len(values) != len(behavior.features) or any(math.isnan(v) for v in values):
        return []
    return values


def _numbers(behavior: Learned | None, state: str, values: list[float]) -> str:
    """Return the numbers for a state in the present situation, and the examples they are from."""
    give = None if behavior is None or not values else behavior.numbers.get(state)
    if behavior is None or give is None:
        return ""
    term = Term.parse(state)
    here = with_numbers(term, give(values), behavior.numbers_of(term))
    like = [f"{m.example} ({m.weight:.0%})" for m in give.nearest(values)]
    return f"Now {here}: as in {'example' if len(like) == 1 else 'examples'} {', '.join(like)}"


def _events(page: Page) -> list[Any]:
    """Return the last `TransitionEvent`s of the agent, the newest first."""
    if page.player is not None:
        return page.player.recording.events(page.player.at, page.agent)
    return list(reversed(page.watched.transitions))


def _label(event: Any) -> str:
    """Return the label of the automaton in which a state changed."""
    return event.automaton[-1] if event.automaton else ""


def _because(page: Page, event: Any) -> str:
    """Return the reason for a state change."""
    seen = ", ".join(
        f"{feature.name} = {measured(page, feature.name, feature.value)}"
        for feature in event.features
    )
    return "commanded" if event.commanded else seen or "always"
