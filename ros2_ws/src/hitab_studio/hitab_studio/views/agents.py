"""The list of agents, as a tree under their commanders."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Set
from typing import Any

from hitab_studio.field.scene import state_shown
from hitab_studio.kept import while_same
from hitab_studio.pages.page import Page
from hitab_studio.swarm.absence import absence

ROWS_MAX = 80
"""Maximum number of rows shown; others are found by typing."""

UNFOLDED_MAX = 40
"""Maximum number of agents for which the tree is initially unfolded."""

AGENT_LEVELS_MAX = 8

NOBODY: frozenset[str] = frozenset()


def context(page: Page) -> dict[str, Any]:
    """Return the variables of the list's template."""
    known, statuses = page.studio.known, page.moment.statuses
    wanted = page.filter.lower()
    if wanted:
        shown = [
            (name, 0, 0, False)
            for name in page.agents
            if wanted in name.lower()
            or (name in statuses and wanted in " ".join(statuses[name].active_path).lower())
        ]
    else:
        shown = list(unfolded(page.agents, known.groups, page.folds, page.agent))
    return {
        "rows": [
            {"name": name, "depth": depth, "below": below, "is_open": is_open}
            | _row(page, statuses.get(name), name)
            for name, depth, below, is_open in shown[:ROWS_MAX]
        ],
        "count": len(shown if wanted else page.agents),
        "more": max(0, len(shown) - ROWS_MAX),
    }


def unfolded(
    agents: Collection[str], groups: Mapping[str, Any], folds: Mapping[str, bool], viewed: str
) -> Iterator[tuple[str, int, int, bool]]:
    """Yield the visible rows: name, depth, number of agents below, and whether unfolded.

    Args:
        agents: names of the agents.
        groups: the last `CommanderStatus` of each commander.
        folds: opened (true) and closed commanders, by name.
        viewed: name of the viewed agent, whose commanders are initially unfolded.
    """
    tops, subordinates, below = _hierarchy(groups, agents)
    few = len(agents) <= UNFOLDED_MAX

    def visible(name: str, depth: int) -> Iterator[tuple[str, int, int, bool]]:
        inside = below.get(name, NOBODY)
        is_open = bool(inside) and folds.get(name, few or viewed in inside)
        yield name, depth, len(inside), is_open
        if is_open and depth < AGENT_LEVELS_MAX:
            for sub in subordinates[name]:
                yield from visible(sub, depth + 1)

    for name in tops:
        yield from visible(name, 0)


@while_same
def _hierarchy(
    groups: Mapping[str, Any], agents: Collection[str]
) -> tuple[list[str], dict[str, list[str]], dict[str, Set[str]]]:
    """Return the agents without a commander, the subordinates, and all agents below each."""
    names = list(agents)
    subordinates = _commanded(groups, names)
    below: dict[str, Set[str]] = {}

    def all_below(name: str, depth: int = 0) -> Set[str]:
        if name in subordinates and name not in below and depth < AGENT_LEVELS_MAX:
            subs = subordinates[name]
            below[name] = {*subs}.union(*(all_below(sub, depth + 1) for sub in subs))
        return below.get(name, NOBODY)

    commanded = {sub for subs in subordinates.values() for sub in subs}
    tops = [name for name in names if name not in commanded]
    for name in tops:
        all_below(name)
    return tops, subordinates, below


def _commanded(groups: Mapping[str, Any], agents: Iterable[str]) -> dict[str, list[str]]:
    """Return the subordinates of each commander, including commanders not heard yet.

    A commander publishes its subordinates and its superior, so a link is known once either end has
    been heard.
    """
    there = {*groups, *agents}
    found = {name: [sub.name for sub in group.subordinates] for name, group in groups.items()}
    for name, group in groups.items():
        if group.superior in there and name not in found.get(group.superior, ()):
            found.setdefault(group.superior, []).append(name)
    return found


def _row(page: Page, status: Any, name: str) -> dict[str, Any]:
    """Return the row of an agent; for a commander, with the order and the number that obey."""
    studio, live = page.studio, page.player is None
    holder = page.studio.held.get(name) if live else None
    state = state_shown(status) if status is not None else ""
    group = studio.known.groups.get(name)
    return {
        "mode": status.mode if status is not None else "",
        "state": state or (status.behavior if status is not None else ""),
        "color": studio.palette.color(state),
        "absence": (absence(studio.known, name) or "") if live else "",
        "machine": studio.known.machine_of.get(name, "") if live else "",
        "lock": "" if holder is None else ("you" if page.is_same(holder) else holder.name),
        "order": group.order if group is not None else "",
        "obeying": sum(member.obeys for member in group.subordinates) if group is not None else 0,
        "size": len(group.subordinates) if group is not None else 0,
        "faults": "\n".join(status.faults) if status is not None else "",
    }
