"""The bar at the top: the name of the swarm, the controls of its world, the emergency stop."""

from __future__ import annotations

import time
from typing import Any

from hitab_ros import names
from hitab_studio.pages import unavailable
from hitab_studio.pages.page import Page
from hitab_studio.swarm.absence import absence
from hitab_studio.views.overlay import empty
from hitab_studio.views.tab_swarm import absent

TEACHING = (1.0, 0.5, 0.25)
"""Factors of the pace while an agent is taught, to choose from."""

SPEEDS = ("0.25", "0.5", "1", "2", "4")


def context(page: Page) -> dict[str, Any]:
    """Return the variables of the bar's template."""
    studio = page.studio
    known = studio.known
    world = known.world
    world_off = unavailable.world(page)
    pace = ""
    if world is not None:
        pace = "lockstep" if world.pace == "lockstep" else f"{world.factor:g}"
    listed = pace in ("", "lockstep", *SPEEDS)
    return {
        **emergency(page),
        "swarm": known.target.swarm if known.target else "",
        "there": len(known.statuses) - sum(name in known.statuses for name in known.silent),
        "agents": len(known.agents),
        "world": world,
        "paused": world is not None and world.mode == "paused",
        "pace": pace,
        "speeds": SPEEDS if listed else sorted((*SPEEDS, pace), key=float),
        "teachings": sorted({*TEACHING, world.teaching} - {0.0}, reverse=True) if world else (),
        "unheard": len([n for n in world.missing if known.answers(n)]) if world else 0,
        "people": {p.browser: p.name for p in page.studio.pages.values() if p.connected},
        "world_off": world_off,
        "unplace_off": world_off or ("" if studio.placements else "Nothing was placed yet."),
        "absent": absence(known, names.WORLD) if world is not None else None,
        "absences": {word: len(who) for word, who in absent(known).items()},
        "unconnected": empty(page)[0],
    }


def emergency(page: Page) -> dict[str, Any]:
    """Return the variables of the emergency stop's button and of the band below the header."""
    known = page.studio.known
    return {
        "stop": known.emergency.who,
        "since": time.strftime("%H:%M:%S", time.localtime(known.stopped_at)),
        # Agents without a simulated world drive real robots, which can do harm.
        "robots": bool(known.statuses) and known.world is None,
    }
