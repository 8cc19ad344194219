"""The sensors of the viewed agent's robot."""

from __future__ import annotations

from collections.abc import Sequence

from hitab_studio.page_state import PageState
from hitab_studio.robots.topics import CAMERA
from hitab_studio.robots.watch import SensorStatus


def rows(session: PageState) -> Sequence[SensorStatus]:
    """Return the sensors of the robot, its camera and the map; none in a replay."""
    robots = session.shared.store.known.robots
    if robots is None or session.player is not None:
        return ()
    return robots.sensors.get(session.agent, ())


def notes(session: PageState) -> Sequence[str]:
    """Return notes about the drawing of the robot."""
    robots = session.shared.store.known.robots
    return () if robots is None else robots.notes.get(session.agent, ())


def camera(session: PageState) -> SensorStatus | None:
    """Return the camera of the robot; None if it has none."""
    return next((one for one in rows(session) if one.kind == CAMERA), None)
