"""What the agents do, and the commanders' orders."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from hitab_ros.names import WORLD
from hitab_studio.markers import STATE_COLORS
from hitab_studio.scene import NO_COLOR, state_shown
from hitab_studio.session import Session


@dataclass(frozen=True)
class Group:
    """A commander with its order and how it is obeyed."""

    name: str
    depth: int
    order: str
    sequence: int
    obeying: int
    silent: int
    size: int


def context(session: Session) -> dict[str, Any]:
    """Return what the tab shows."""
    store = session.shared.store
    states = Counter(
        state_shown(s.active_path) or s.behavior or "nothing"
        for s in store.known.statuses.values()
    )
    digests = Counter(s.library_digest for s in store.known.statuses.values())
    total = max(1, sum(states.values()))
    return {
        "shares": [
            (state, count, 100 * count / total, _color(store.palette.index(state)))
            for state, count in states.most_common(12)
        ],
        "modes": Counter(s.mode for s in store.known.statuses.values()),
        "groups": list(_groups(store.known.groups)),
        "libraries": len(digests),
        "stoppable": _stoppable(session),
        "gone": sorted({*store.known.gone, *store.known.silent} - {WORLD}),
        "errors": [(n, s.last_error) for n, s in store.known.statuses.items() if s.last_error][:6],
    }


def _stoppable(session: Session) -> str:
    """Return the swarm that may be stopped here; "" if there is none."""
    target, launcher = session.shared.store.known.target, session.shared.launcher
    if target is None or target.problem or not target.identity or launcher.is_busy:
        return ""
    return target.swarm if launcher.startable else ""


def _color(index: int) -> str:
    return "" if index == NO_COLOR else STATE_COLORS[index]


def _groups(groups: Any) -> Iterator[Group]:
    def under(name: str, depth: int) -> Iterator[Group]:
        group = groups[name]
        yield Group(
            name,
            depth,
            group.order,
            group.sequence,
            sum(group.obeying),
            sum(group.silent),
            len(group.subordinates),
        )
        for sub in group.subordinates:
            if sub in groups and depth < 8:
                yield from under(sub, depth + 1)

    for name, group in sorted(groups.items()):
        if group.superior not in groups:
            yield from under(name, 0)
