"""What was learned: the hierarchy of automata, one of them drawn, a state's tree, and why."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from hitab_client import Learned
from hitab_core import FLAGS, START, Use
from hitab_studio.graph import graph
from hitab_studio.learned import is_taken_out
from hitab_studio.session import Session
from hitab_studio.tree_rows import tree_rows
from hitab_studio.views.numbers import measured

SHOWN = 8
"""Changes of state that are listed."""


@dataclass(frozen=True)
class Level:
    """One automaton of the hierarchy.

    Attributes:
        label: as in the path of active states, such as ``GoTo(ball)``.
        state: its active state; "" if it is not active.
    """

    name: str
    label: str
    depth: int
    state: str
    shown: bool


def context(session: Session) -> dict[str, Any]:
    """Return what the tab shows."""
    levels = _levels(session)
    shown = next((level for level in levels if level.shown), None)
    behavior = _behavior(session, shown.name) if shown is not None else None
    automaton = behavior.automaton if behavior is not None else None
    state = (session.state or (shown.state if shown else "")) or START
    tree = behavior.tree(state) if behavior is not None else None
    values = _values(session, shown, behavior)
    events = _events(session)
    names = behavior.features if behavior is not None else ()
    automata = [b.name for b in session.watched.behaviors.values() if b.is_automaton]
    return {
        "levels": levels,
        "level": shown,
        "behavior": behavior,
        "taken_out": behavior is not None and is_taken_out(behavior),
        "graph": graph(automaton, automata) if automaton else None,
        "state": state,
        "last": next((e for e in events if shown and _label(e) == shown.label), None),
        "rows": tree_rows(tree, names, dict(zip(names, values, strict=False))) if tree else [],
        "live": bool(values),
        "changes": events[:SHOWN],
        "because": lambda event: _because(session, event),
        "label": _label,
    }


def _behavior(session: Session, name: str) -> Learned | None:
    training = session.watched.training
    if training is not None and training.name == name and session.is_training:
        return training
    return session.watched.behaviors.get(name)


def _levels(session: Session) -> list[Level]:
    """Return the hierarchy below what the agent performs, active or not, outermost first."""
    status = session.status
    if status is None:
        return []
    top = status.behavior
    if not top and session.watched.training is not None:
        top = session.watched.training.name
    if not top and session.behavior:
        top = session.behavior
    if not top:
        return []
    path = list(status.active_path)
    found: list[tuple[str, str, int, str]] = []

    def visit(label: str, depth: int, active: int | None) -> None:
        name = Use.parse(label).name
        behavior = _behavior(session, name)
        if behavior is None or not behavior.is_automaton or depth > 6:
            return
        state = path[active] if active is not None and active < len(path) else ""
        if any(name == other for other, _, _, _ in found):
            return
        found.append((name, label, depth, state))
        for inner in behavior.states or ():
            if Use.parse(inner).name in FLAGS:
                continue
            inner_active = active + 1 if active is not None and inner == state else None
            visit(inner, depth + 1, inner_active)

    visit(top, 0, 0)
    chosen = session.level if any(n == session.level for n, *_ in found) else ""
    return [
        Level(name, label, depth, state, name == chosen if chosen else i == 0)
        for i, (name, label, depth, state) in enumerate(found)
    ]


def _values(session: Session, level: Level | None, behavior: Learned | None) -> list[float]:
    """Return the values that the automaton's features have now, if it is active."""
    if level is None or behavior is None or session.player is not None:
        return []
    there = [
        (feature, values[-1])
        for (automaton, feature), values in list(session.watched.readings.items())
        if automaton == level.label and values
    ]
    values = [value for _, value in there]
    if len(values) != len(behavior.features) or any(math.isnan(v) for v in values):
        return []
    return values


def _events(session: Session) -> list[Any]:
    """Return the last `TransitionEvent`s of the agent, the newest first."""
    if session.player is not None:
        return session.player.recording.events(session.player.at, session.agent)
    return list(reversed(session.watched.transitions))


def _label(event: Any) -> str:
    """Return the label of the automaton in which a state changed."""
    return event.automaton[-1] if event.automaton else ""


def _because(session: Session, event: Any) -> str:
    """Say why a state changed."""
    seen = ", ".join(
        f"{feature} = {measured(session, feature, value)}"
        for feature, value in zip(event.features, event.values, strict=True)
    )
    return "commanded" if event.commanded else seen or "always"
