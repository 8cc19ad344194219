"""The activities of agents, and the swarms that are up."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from typing import Any

from hitab_core import each_once, in_groups, natural, some
from hitab_studio.field.scene import state_shown
from hitab_studio.pages.page import Page
from hitab_studio.swarm.absence import NOT_HEARD, absence
from hitab_studio.swarm.swarm_finder import SwarmTarget
from hitab_studio.swarm.swarm_state import SwarmState

DAY = 24 * 3600

ITEMS_MAX = 20
"""Maximum number of items shown that deserve a look."""


def context(page: Page) -> dict[str, Any]:
    """Return the variables of the tab's template."""
    studio = page.studio
    statuses = studio.known.statuses.values()
    superiors = {status.agent: status.order.commander for status in statuses}
    halting = [status.agent for status in statuses if status.when_out_of_reach == "halt"]
    ran = Counter(studio.known.machine_of.values())
    states = Counter(state_shown(s) or s.behavior or "nothing" for s in statuses)
    return {
        "shares": [
            (state, count, 100 * count / len(statuses), studio.palette.color(state))
            for state, count in states.most_common(12)
        ],
        "modes": Counter(s.mode for s in statuses),
        "expected": len(studio.known.agents),
        "waiting": studio.known.is_waiting,
        "libraries": len({s.library_digest for s in statuses}),
        "items": studio.known.attention[:ITEMS_MAX],
        "more_items": len(studio.known.attention[ITEMS_MAX:]),
        "stoppable": _stoppable(page),
        "machines": {m: ran[m] for m in sorted(studio.known.machines, key=natural)},
        "choices": choices(page),
        "absences": {w: some(sorted(who, key=natural)) for w, who in absent(studio.known).items()},
        "halting": some(in_groups(halting, superiors)),
        "errors": each_once((s.agent, s.last_error) for s in statuses if s.last_error)[:6],
    }


def absent(known: SwarmState) -> dict[str, list[str]]:
    """Return the absent agents by state of absence, without those that may still appear."""
    found: dict[str, list[str]] = {}
    for name in sorted({*known.silent, *known.unheard} & known.members, key=natural):
        how = absence(known, name)
        if how is not None and how.state != NOT_HEARD:
            found.setdefault(how.state, []).append(name)
    return found


def choices(page: Page) -> Sequence[SwarmTarget]:
    """Return the other running swarms, sorted by name and age."""
    target = page.studio.known.target
    if target is None or page.player is not None:
        return []
    found = sorted(target.choices, key=lambda choice: (choice.swarm, choice.start))
    return [choice for choice in found if target.problem or choice.folder != target.folder]


def since(moment: float) -> str:
    """Return a time of day, with the date if more than a day ago."""
    recent = time.time() - moment < DAY
    return time.strftime("%H:%M:%S" if recent else "%d %b, %H:%M", time.localtime(moment))


def _stoppable(page: Page) -> str:
    """Return the name of the swarm if the page may stop it; "" otherwise."""
    target, launcher = page.studio.known.target, page.studio.launcher
    if target is None or target.problem or not target.folder or launcher.is_busy:
        return ""
    return target.swarm if launcher.startable else ""
