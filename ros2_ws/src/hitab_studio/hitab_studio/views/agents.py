"""The list of agents, under their commanders where there are any."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from hitab_studio.markers import STATE_COLORS
from hitab_studio.scene import NO_COLOR, state_shown
from hitab_studio.session import Session

MOST = 80
"""Rows that are shown; more are found by typing."""


@dataclass(frozen=True)
class Row:
    """One agent."""

    name: str
    depth: int
    mode: str
    state: str
    color: str
    chosen: bool
    absence: str
    lock: str
    order: str
    faults: str


def context(session: Session) -> dict[str, Any]:
    """Return what the list shows."""
    statuses = (
        session.player.recording.statuses(session.player.at)
        if session.player is not None
        else session.shared.store.known.statuses
    )
    ordered = list(_ordered(session))
    wanted = session.filter.lower()
    if wanted:
        ordered = [
            (name, depth)
            for name, depth in ordered
            if wanted in name.lower()
            or (name in statuses and wanted in " ".join(statuses[name].active_path).lower())
        ]
    return {
        "rows": [_row(session, statuses, name, depth) for name, depth in ordered[:MOST]],
        "count": len(ordered),
        "more": max(0, len(ordered) - MOST),
        "filter": session.filter,
    }


def _ordered(session: Session) -> Iterator[tuple[str, int]]:
    """Yield agents with their depth in the tree of commanders."""
    groups = session.shared.store.known.groups
    agents = session.agents
    below = {sub for group in groups.values() for sub in group.subordinates}

    def under(name: str, depth: int) -> Iterator[tuple[str, int]]:
        yield name, depth
        if name in groups and depth < 8:
            for sub in groups[name].subordinates:
                yield from under(sub, depth + 1)

    for name in agents:
        if name not in below:
            yield from under(name, 0)


def _absence(session: Session, name: str) -> str:
    """Return one word for how an agent is absent; empty if it answers."""
    known = session.shared.store.known
    if known.answers(name):
        return ""
    return "silent" if name in known.silent and name not in known.gone else "not there"


def _row(session: Session, statuses: Any, name: str, depth: int) -> Row:
    store = session.shared.store
    status = statuses.get(name)
    holder = session.shared.locks.holder(name)
    state = state_shown(status.active_path) if status is not None else ""
    index = store.palette.index(state)
    group = store.known.groups.get(name)
    return Row(
        name=name,
        depth=depth,
        mode=status.mode if status is not None else "",
        state=state or (status.behavior if status is not None else ""),
        color="" if index == NO_COLOR else STATE_COLORS[index],
        chosen=name == session.agent,
        absence=_absence(session, name) if session.player is None else "",
        lock="" if holder is None else ("you" if holder.session == session.id else holder.name),
        order=group.order if group is not None else "",
        faults="\n".join(status.faults) if status is not None else "",
    )
