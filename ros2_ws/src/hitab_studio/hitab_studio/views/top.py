"""The bar at the top: the name of the swarm, and the controls of its world."""

from __future__ import annotations

from collections import Counter
from typing import Any

from hitab_ros import names
from hitab_studio import unavailable
from hitab_studio.absence import NOT_HEARD, absence
from hitab_studio.known import Known
from hitab_studio.session import Session
from hitab_studio.views import emergency
from hitab_studio.views.overlay import startable

SPEEDS = ("0.25", "0.5", "1", "2", "4")


def context(session: Session) -> dict[str, Any]:
    """Return what the bar shows."""
    store = session.shared.store
    world, scene = store.known.world, store.known.scene
    world_off = unavailable.world(session)
    pace = ""
    if world is not None:
        pace = "lockstep" if world.pace == "lockstep" else f"{world.factor:g}"
    listed = pace in ("", "lockstep", *SPEEDS)
    return {
        **emergency.context(session),
        "swarm": store.known.target.swarm if store.known.target else "",
        "there": sum(map(store.known.answers, store.known.agents)),
        "agents": len(store.known.agents),
        "waiting": store.known.is_waiting,
        "world": world,
        "paused": world is not None and world.mode == "paused",
        "scene": scene,
        "pace": pace,
        "speeds": SPEEDS if listed else sorted((*SPEEDS, pace), key=float),
        "unheard": len([n for n in world.missing if store.known.answers(n)]) if world else 0,
        "pages": sum(other.connected for other in session.shared.sessions.values()),
        "replaying": session.player is not None,
        "real": store.known.robots is not None,
        "world_off": world_off,
        "unplace_off": world_off or ("" if store.placements else "Nothing was placed yet."),
        "absent": absence(store.known, names.WORLD) if world is not None else None,
        "absences": _absences(store.known),
        "unconnected": _unconnected(session),
    }


def _unconnected(session: Session) -> str:
    """Say to what the page is not connected, and what to do about it."""
    target, launch = session.shared.store.known.target, session.shared.launcher.launch
    if launch is not None and launch.status is None and launch.verb == "up":
        return f"not connected to {launch.swarm} yet: it is starting"
    if target is not None and target.choices and target.problem:
        return "not connected to a swarm: choose one below"
    if target is not None and target.swarm and not target.problem:
        return f"not connected to {target.swarm} yet: it does not answer"
    where = "below" if startable(session) else "in a terminal"
    return f"not connected to a swarm: start one {where}"


def _absences(known: Known) -> list[tuple[int, str]]:
    """Return how many agents are absent, by how; without those that may still come."""
    found = filter(None, (absence(known, name) for name in known.agents))
    words = Counter(absent.word for absent in found if absent.word != NOT_HEARD)
    return [(count, word) for word, count in words.items()]
