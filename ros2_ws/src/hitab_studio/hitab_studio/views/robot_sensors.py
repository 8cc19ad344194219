"""The sensors of the viewed agent's robot."""

from __future__ import annotations

from collections.abc import Sequence

from hitab_studio.pages.page import Page
from hitab_studio.robots.topics import CAMERA
from hitab_studio.robots.watch import SensorStatus


def rows(page: Page) -> Sequence[SensorStatus]:
    """Return the sensors of the robot, with the camera and the map; () in a replay."""
    robots = page.studio.known.robots
    if robots is None or page.player is not None:
        return ()
    return robots.sensors.get(page.agent, ())


def notes(page: Page) -> Sequence[str]:
    """Return remarks on how the robot is drawn."""
    robots = page.studio.known.robots
    return () if robots is None else robots.notes.get(page.agent, ())


def camera(page: Page) -> SensorStatus | None:
    """Return the camera of the robot; None if there is none."""
    return next((one for one in rows(page) if one.kind == CAMERA), None)
