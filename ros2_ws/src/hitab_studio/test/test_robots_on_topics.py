"""Real robots in the studio: topics are found, and messages drawn or refused."""

import asyncio
import math
import re
import time
from collections.abc import Awaitable, Callable
from typing import Any

import numpy as np
import pytest

from hitab_client.errors import SwarmError
from hitab_studio.pages.page import Page
from hitab_studio.pages.page_view import perform
from hitab_studio.studio import Studio
from hitab_studio.views import render

SECONDS = 60.0
ROBOT = "robot_1"


class OpenPage:
    """An open page of a studio."""

    def __init__(self, studio: Studio) -> None:
        self.studio = studio
        self.page: Page = studio.open()
        self.page.look_at(ROBOT)
        self.page.connected = True

    @property
    def known(self) -> Any:
        return self.studio.known

    async def until(self, true: Callable[[], Any]) -> None:
        deadline = time.monotonic() + SECONDS
        while not true():
            assert time.monotonic() < deadline, "it did not happen in time"
            await asyncio.sleep(0.01)

    def stands(self, *expected: float) -> bool:
        """Whether the page shows the robot at this pose."""
        scene = self.known.shown
        return scene is not None and np.allclose(scene.places[0, :3], expected, atol=1e-5)

    def points(self) -> Any:
        """Return the points of the scan on the page."""
        return np.frombuffer(self.page.layers()["scans"][4:], "<f4").tolist()

    def shown(self, panel: str) -> str:
        return re.sub(r"\s+", " ", render(panel, self.page))


def at_a_page(robot: Any, term: Callable[[OpenPage], Awaitable[None]]) -> None:
    async def run() -> None:
        studio = Studio(lambda: robot.target)
        await studio.start()
        try:
            await term(OpenPage(studio))
        finally:
            await studio.stop()

    asyncio.run(asyncio.wait_for(run(), 3 * SECONDS))


def test_a_robot_is_drawn_where_its_odometry_is_and_what_it_scans_where_that_is(robot):
    robot.stand(3.0, 1.0, math.pi / 2)
    robot.see(math.nan, 0.05, 2.0, math.inf)  # one return, straight ahead of the scanner

    async def term(page: OpenPage) -> None:
        await page.until(lambda: page.stands(3.0, 1.0, math.pi / 2))
        # The scanner faces left of the robot (scan.yaw), and the robot faces y: so it faces -x.
        await page.until(lambda: np.allclose([*page.points(), 0, 0][:2], [1.0, 1.0], atol=1e-5))
        assert not page.known.robots.notes[ROBOT]
        for topic in ("odom", "scan"):
            row = rf'sensor-/{ROBOT}/{topic}"((?!sensor-).)*\d\.\d s ago'
            await page.until(lambda row=row: re.search(row, page.shown("side")))
        robot.scan = None
        await page.until(lambda: not page.points())
        assert page.known.doing()[ROBOT][0] != "silent"
        robot.odometry = None
        await page.until(lambda: page.known.doing()[ROBOT][0] == "silent")

    at_a_page(robot, term)


def test_what_needs_a_world_is_not_offered_for_robots_and_one_is_seen_when_its_agent_has_ended(
    robot,
):

    async def term(page: OpenPage) -> None:
        await page.until(lambda: page.stands(0.0, 0.0, 0.0))
        await page.until(lambda: "real robots" in page.shown("top"))
        assert 'data-test="pause"' not in page.shown("top")
        for wish in ({"do": "pause"}, {"do": "reset"}, {"do": "step"}):
            await perform(page.page, wish)
        await perform(page.page, {"do": "place", "things": {ROBOT: {"x": 1.0, "y": 1.0}}})
        assert "These are real robots: they cannot be paused" in page.shown("messages")
        with pytest.raises(SwarmError, match="real robots"):
            await page.page.ask_world(lambda world: None)
        robot.end_agent()
        await page.until(lambda: ROBOT in page.known.silent)
        robot.stand(2.0, 0.0, 0.0)
        await page.until(lambda: page.stands(2.0, 0.0, 0.0))
        await page.until(lambda: page.known.doing()[ROBOT][0] == "silent")

    at_a_page(robot, term)


def test_what_pages_show_is_listened_to_and_what_cannot_be_shown_refused(robot):

    robot.film(b"no picture")
    robot.draw_map([[0, 100]], 0.5, -1.0, 0.0, 0.0)

    async def term(page: OpenPage) -> None:
        await page.until(lambda: "is neither JPEG nor PNG" in page.shown("overlay"))
        robot.film(robot.png(4, 3))
        await page.until(lambda: {"map", f"camera {ROBOT}"} <= page.page.layers().keys())
        assert page.page.layers()[f"camera {ROBOT}"][4:] == robot.png(4, 3)
        robot.stand(math.nan, 0.0, 0.0)
        await page.until(lambda: "no valid position" in page.shown("side"))
        await page.until(lambda: page.known.shown is None)  # its pose is unknown
        await page.until(lambda: "No robot has a place yet" in page.shown("overlay"))
        robot.stand(1.0, 0.0, 0.0)
        await page.until(lambda: page.stands(1.0, 0.0, 0.0))
        page.page.look_at("")
        await page.until(lambda: not robot.listeners("picture"))
        page.page.connected = False
        await page.until(lambda: robot.listeners("odometry") == 1)  # the agent's

    at_a_page(robot, term)
