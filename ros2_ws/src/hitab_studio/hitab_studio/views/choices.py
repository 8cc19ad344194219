"""The swarms that are up and may be shown."""

from __future__ import annotations

import time
from dataclasses import dataclass

from hitab_studio.session import Session

DAY = 24 * 3600


@dataclass(frozen=True)
class Row:
    """A swarm to click; `since` is in words."""

    swarm: str
    folder: str
    since: str
    agents: int


def choices(session: Session) -> list[Row]:
    """Return the swarms that may be shown instead of the present one, by name, oldest first."""
    target = session.shared.store.known.target
    if target is None or session.player is not None:
        return []
    return [
        Row(choice.swarm, choice.folder, _since(choice.since), choice.agents)
        for choice in sorted(target.choices, key=lambda c: (c.swarm, c.since))
        if target.problem or choice.folder != target.folder
    ]


def _since(moment: int) -> str:
    """Return a time of day, with the date if that is longer ago than a day."""
    recent = time.time() - moment < DAY
    return time.strftime("%H:%M:%S" if recent else "%d %b, %H:%M", time.localtime(moment))
