"""The list of agents, under their commanders where there are any."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hitab_studio.absence import absence
from hitab_studio.markers import STATE_COLORS
from hitab_studio.scene import NO_COLOR, state_shown
from hitab_studio.session import Session
from hitab_studio.views.agent_tree import Branch, tree, unfolded

MOST = 80
"""Rows that are shown; more are found by typing."""


@dataclass(frozen=True)
class Row:
    """One agent, or the title of agents that are called alike.

    Attributes:
        fold: "open" or "closed", if there are agents below it.
        below: number of agents below it; of a title, of those that are called so.
        also: of a title, number of agents under these.
        mode: None for a title.
    """

    name: str
    depth: int
    fold: str = ""
    below: int = 0
    also: int = 0
    mode: str | None = None
    state: str = ""
    color: str = ""
    chosen: bool = False
    absence: str = ""
    lock: str = ""
    order: str = ""
    faults: str = ""


def context(session: Session) -> dict[str, Any]:
    """Return what the list shows."""
    statuses = (
        session.player.recording.statuses(session.player.at)
        if session.player is not None
        else session.shared.store.known.statuses
    )
    branches = tree(session.agents, session.shared.store.known.groups)
    wanted = session.filter.lower()
    if wanted:
        shown = [
            (Branch(branch.name), 0, "")
            for branch in (b for top in branches for b in top.all())
            if branch.is_agent
            and (
                wanted in branch.name.lower()
                or (
                    branch.name in statuses
                    and wanted in " ".join(statuses[branch.name].active_path).lower()
                )
            )
        ]
        count = len(shown)
    else:
        shown = list(unfolded(branches, session.folds, session.agent))
        count = sum(branch.size for branch in branches)
    return {
        "rows": [
            _row(session, statuses, branch.name, depth, fold, branch.size - branch.is_agent)
            if branch.is_agent
            else _title(branch, depth, fold)
            for branch, depth, fold in shown[:MOST]
        ],
        "count": count,
        "more": max(0, len(shown) - MOST),
        "filter": session.filter,
        "replays": session.player is not None,
    }


def _title(branch: Branch, depth: int, fold: str) -> Row:
    named = len(branch.below)
    return Row(name=branch.name, depth=depth, fold=fold, below=named, also=branch.size - named)


def _row(session: Session, statuses: Any, name: str, depth: int, fold: str, below: int) -> Row:
    store = session.shared.store
    status = statuses.get(name)
    holder = session.shared.held.get(name) if session.player is None else None
    state = state_shown(status.active_path) if status is not None else ""
    index = store.palette.index(state)
    group = store.known.groups.get(name)
    absent = absence(store.known, name) if session.player is None else None
    return Row(
        name=name,
        depth=depth,
        fold=fold,
        below=below,
        mode=status.mode if status is not None else "",
        state=state or (status.behavior if status is not None else ""),
        color="" if index == NO_COLOR else STATE_COLORS[index],
        chosen=name == session.agent,
        absence=absent.word if absent is not None else "",
        lock="" if holder is None else ("you" if holder is session else holder.name),
        order=group.order if group is not None else "",
        faults="\n".join(status.faults) if status is not None else "",
    )
