"""What the agents do, and the commanders' orders."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hitab_core import natural, some
from hitab_studio.absence import absence
from hitab_studio.known import Known
from hitab_studio.markers import STATE_COLORS
from hitab_studio.scene import NO_COLOR, state_shown
from hitab_studio.session import Session
from hitab_studio.views.agent_tree import DEEPEST, commanded
from hitab_studio.views.choices import choices


@dataclass(frozen=True)
class Group:
    """A commander with its order and how it is obeyed; `order` is None if it was not heard yet."""

    name: str
    depth: int
    order: str | None
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
        "groups": list(_groups(store.known.groups, store.known.agents)),
        "expected": len(store.known.agents),
        "waiting": store.known.is_waiting,
        "libraries": len(digests),
        "stoppable": _stoppable(session),
        "choices": choices(session),
        "absences": _absences(store.known),
        "errors": [(n, e) for n, s in store.known.statuses.items() if (e := s.last_error)][:6],
    }


def _absences(known: Known) -> dict[str, str]:
    """Return who was heard and is absent now, by how."""
    found: dict[str, list[str]] = {}
    for name in known.statuses:
        if (absent := absence(known, name)) is not None:
            found.setdefault(absent.word, []).append(name)
    return {word: some(sorted(absent, key=natural)) for word, absent in found.items()}


def _stoppable(session: Session) -> str:
    """Return the swarm that may be stopped here; "" if there is none."""
    target, launcher = session.shared.store.known.target, session.shared.launcher
    if target is None or target.problem or not target.folder or launcher.is_busy:
        return ""
    return target.swarm if launcher.startable else ""


def _color(index: int) -> str:
    return "" if index == NO_COLOR else STATE_COLORS[index]


def _groups(groups: Mapping[str, Any], agents: Sequence[str]) -> Iterator[Group]:
    """Yield the commanders, each above those that it commands."""
    below = commanded(groups, agents)

    def under(name: str, depth: int) -> Iterator[Group]:
        if (group := groups.get(name)) is None:
            yield Group(name, depth, None, 0, 0, len(below[name]))
        else:
            obeying = sum(member.obeys for member in group.subordinates)
            silent = sum(member.silent for member in group.subordinates)
            yield Group(name, depth, group.order, obeying, silent, len(group.subordinates))
        for sub in sorted(below[name], key=natural):
            if sub in below and depth < DEEPEST:
                yield from under(sub, depth + 1)

    commands = {sub for subs in below.values() for sub in subs}
    for name in sorted(below.keys() - commands, key=natural):
        yield from under(name, 0)
