"""Real robots in the studio: what they publish is found, drawn where it is, or refused."""

import asyncio
import math
import re
import time
from collections.abc import Awaitable, Callable
from typing import Any

import numpy as np
import pytest

from hitab_client.errors import SwarmError
from hitab_studio.actions import perform
from hitab_studio.session import Session
from hitab_studio.studio import Studio
from hitab_studio.viewing import CAMERA, MAP
from hitab_studio.views import render

SECONDS = 60.0
ROBOT = "robot_1"


class Page:
    """A page that is open."""

    def __init__(self, studio: Studio) -> None:
        self.studio = studio
        self.session: Session = studio.open()
        self.session.look_at(ROBOT)
        studio.link.viewing.connect(self.session.id, on=True)

    @property
    def known(self) -> Any:
        return self.studio.store.known

    async def until(self, true: Callable[[], Any], leases: tuple[str, ...] = ()) -> None:
        deadline = time.monotonic() + SECONDS
        while not true():
            for what in leases:
                self.studio.link.viewing.lease(what, ROBOT if what == CAMERA else "")
            assert time.monotonic() < deadline, "it did not happen in time"
            await asyncio.sleep(0.01)

    def place(self) -> tuple[float, ...] | None:
        """Return where the page shows the robot."""
        scene = self.known.shown
        return tuple(scene.places[0, :3].tolist()) if scene is not None else None

    def points(self) -> Any:
        """Return what the page shows of what the scanner sees."""
        return np.frombuffer(self.known.robots.scans[16:], "<f4").reshape(-1, 2)

    def shown(self, panel: str) -> str:
        return re.sub(r"\s+", " ", render(panel, self.session))


def at_a_page(robot: Any, use: Callable[[Page], Awaitable[None]]) -> None:
    async def run() -> None:
        studio = Studio(lambda: robot.target)
        await studio.start()
        try:
            await use(Page(studio))
        finally:
            await studio.stop()

    asyncio.run(asyncio.wait_for(run(), 3 * SECONDS))


def near(place: Any, *expected: Any) -> bool:
    found = place is not None and np.shape(place) == np.shape(expected)
    return bool(found and np.allclose(place, expected, atol=1e-5))


def test_a_robot_is_drawn_where_its_odometry_is_and_what_it_scans_where_that_is(robot):
    robot.stand(3.0, 1.0, math.pi / 2)
    robot.see(math.nan, 0.05, 2.0, math.inf)  # one return, straight ahead of the scanner

    async def use(page: Page) -> None:
        await page.until(lambda: near(page.place(), 3.0, 1.0, math.pi / 2))
        # The scanner faces left of the robot (scan.yaw), and the robot faces y: so it faces -x.
        await page.until(lambda: near(page.points().tolist(), [1.0, 1.0]))
        assert not page.known.robots.of(ROBOT).notes
        for topic in ("odom", "scan"):
            row = rf'sensor-/{ROBOT}/{topic}"((?!sensor-).)*\d\.\d s ago'
            await page.until(lambda row=row: re.search(row, page.shown("side")))
        robot.scan = None
        await page.until(lambda: "silent for" in page.shown("side"))
        await page.until(lambda: "scan (silent for" in page.shown("overlay"))
        await page.until(lambda: page.known.doing()[ROBOT][0] != "silent")
        await page.until(lambda: not len(page.points()))
        robot.odometry = None
        await page.until(lambda: page.known.doing()[ROBOT][0] == "silent")

    at_a_page(robot, use)


def test_what_needs_a_world_is_not_offered_for_robots(robot):
    robot.stand(0.0, 0.0, 0.0)

    async def use(page: Page) -> None:
        await page.until(page.place)
        await page.until(lambda: "real robots" in page.shown("top"))
        assert 'data-test="pause"' not in page.shown("top")
        assert "No world" not in page.shown("overlay")
        for wish in ({"do": "pause"}, {"do": "reset"}, {"do": "step"}):
            await perform(page.session, wish)
        await perform(page.session, {"do": "place", "things": {ROBOT: {"x": 1.0, "y": 1.0}}})
        said = page.shown("messages")
        assert "These are real robots: they cannot be paused" in said
        with pytest.raises(SwarmError, match="real robots"):
            await page.session.ask_world(lambda world: None)

    at_a_page(robot, use)


def test_a_robot_is_seen_after_its_agent_has_ended_too(robot):
    robot.stand(0.0, 0.0, 0.0)

    async def use(page: Page) -> None:
        await page.until(page.place)
        robot.end_agent()
        await page.until(lambda: ROBOT in page.known.gone)
        robot.stand(2.0, 0.0, 0.0)
        await page.until(lambda: near(page.place(), 2.0, 0.0, 0.0))
        await page.until(lambda: page.known.doing()[ROBOT][0] == "silent")

    at_a_page(robot, use)


def test_nothing_is_listened_to_that_no_page_shows(robot):
    robot.stand(0.0, 0.0, 0.0)
    robot.film(robot.png(4, 3))
    robot.draw_map([[0, 100]], 0.5, -1.0, 0.0, 0.0)

    async def use(page: Page) -> None:
        own = robot.listeners("odometry")  # the agent's, and that of the studio
        await page.until(page.place)
        await page.until(lambda: robot.listeners("odometry") == 2)
        assert robot.listeners("picture") == robot.listeners("map") == 0
        camera = lambda: page.known.robots.of(ROBOT).camera  # noqa: E731
        await page.until(lambda: camera().picture, (CAMERA,))
        assert camera().picture.data == robot.png(4, 3)
        assert robot.listeners("map") == 0
        await page.until(lambda: page.known.robots.map.grid, (MAP,))
        await page.until(lambda: not robot.listeners("picture") + robot.listeners("map"))
        page.studio.link.viewing.connect(page.session.id, on=False)
        await page.until(lambda: robot.listeners("odometry") == 1)
        assert own

    at_a_page(robot, use)


def test_what_cannot_be_shown_is_refused_once_with_a_word(robot):
    robot.stand(0.0, 0.0, 0.0)
    robot.film(bytes(9_000_000), "jpeg")
    robot.draw_map([[0]], math.nan, 0.0, 0.0, 0.0)

    async def use(page: Page) -> None:
        await page.until(page.place)
        camera = f"/{ROBOT}/camera/image_raw/compressed"
        for what, text in (
            (CAMERA, f"{camera} sends 9 MB in one message; up to 8 MB are shown"),
            (MAP, "/map has cells of nan m"),
        ):
            await page.until(lambda text=text: text in page.shown("messages"), (what,))
        await page.until(lambda: not robot.listeners("picture"), (CAMERA,))
        robot.stand(math.nan, 0.0, 0.0)
        await page.until(lambda: "which is nowhere" in page.shown("messages"))
        await page.until(lambda: page.known.shown is None)  # nobody knows where it is
        await page.until(lambda: "No robot has a place yet" in page.shown("overlay"))
        assert page.shown("messages").count("which is nowhere") == 1
        robot.stand(1.0, 0.0, 0.0)
        await page.until(lambda: near(page.place(), 1.0, 0.0, 0.0))

    at_a_page(robot, use)
