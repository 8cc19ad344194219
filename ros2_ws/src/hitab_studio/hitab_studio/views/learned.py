"""What was learned: the hierarchy of automata, one of them drawn, a state's tree, and why."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from hitab_client import Learned
from hitab_core import FLAGS, START, Use
from hitab_studio.graph import graph
from hitab_studio.learned import is_taken_out
from hitab_studio.session import Session
from hitab_studio.tree_rows import tree_rows
from hitab_studio.views.numbers import measured


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


@dataclass(frozen=True)
class Change:
    """A state change and why it happened."""

    cycle: int
    automaton: str
    source: str
    target: str
    why: str
    probability: float
    commanded: bool


def context(session: Session) -> dict[str, Any]:
    """Return what the tab shows."""
    levels = _levels(session)
    shown = next((level for level in levels if level.shown), None)
    behavior = _behavior(session, shown.name) if shown is not None else None
    automaton = behavior.automaton if behavior is not None else None
    state = (session.state or (shown.state if shown else "")) or START
    tree = behavior.tree(state) if behavior is not None else None
    values = _values(session, shown, behavior)
    changes = _changes(session)
    last = next((c for c in changes if shown and c.automaton == shown.label), None)
    names = _names(behavior, session)
    return {
        "levels": levels,
        "level": shown,
        "behavior": behavior,
        "taken_out": behavior is not None and is_taken_out(behavior),
        "graph": graph(automaton, [b.name for b in _automata(session)]) if automaton else None,
        "state": state,
        "last": last,
        "rows": tree_rows(tree, names, dict(zip(names, values, strict=False))) if tree else [],
        "live": bool(values),
        "chances": dict(behavior.decides(state, values)) if behavior and values else {},
        "changes": changes[:8],
    }


def _automata(session: Session) -> list[Learned]:
    found = [b for b in session.watched.behaviors.values() if b.is_automaton]
    training = session.watched.training
    return [*found, training] if training is not None else found


def _behavior(session: Session, name: str) -> Learned | None:
    training = session.watched.training
    if training is not None and training.name == name and session.is_training:
        return training
    return session.watched.behaviors.get(name)


def _names(behavior: Learned | None, session: Session) -> Sequence[str]:
    return behavior.features if behavior is not None else ()


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


def _changes(session: Session) -> list[Change]:
    if session.player is not None:
        events = session.player.recording.events(session.player.at, session.agent)
    else:
        events = list(reversed(session.watched.transitions))
    found = []
    for event in events:
        seen = ", ".join(
            f"{feature} = {measured(session, feature, value)}"
            for feature, value in zip(event.features, event.values, strict=True)
        )
        found.append(
            Change(
                event.cycle,
                event.automaton[-1] if event.automaton else "",
                event.from_state,
                event.to_state,
                "commanded" if event.commanded else seen or "always",
                event.probability,
                event.commanded,
            )
        )
    return found
