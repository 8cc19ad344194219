"""The studio with a real robot: its sensors come over topics, and there is no world.

The agent is a real one, of examples/diff_drive; the robot is a node here, so that the test knows
what it sees.
"""

from __future__ import annotations

import array
import io
import math
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from browsing import Person, needs_browser, studio
from geometry_msgs.msg import Twist
from mentions import ROOT
from nav_msgs.msg import OccupancyGrid, Odometry
from PIL import Image
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CompressedImage, LaserScan

from hitab_client import RosLink, SwarmClient, domain_ids
from hitab_ros import qos

ROBOT = "robot_1"
SECONDS = 60.0
PERIOD = 0.05
RED = (230, 20, 20)
X, Y, YAW = 2.0, 1.0, math.pi / 2  # of the robot
CELL = 0.5  # m
WALL = (3.0, 0.5)  # m: where the map has an occupied cell, and the scanner a return


def red_jpeg() -> bytes:
    out = io.BytesIO()
    Image.new("RGB", (64, 48), RED).save(out, "JPEG")
    return out.getvalue()


class Robot:
    """Publishes what a robot publishes, in a thread of its own, until it is stopped.

    Attributes:
        silent: topics on which nothing is published at present.
        driven: the velocity that was sent to the base.
    """

    def __init__(self, domain_id: int) -> None:
        self.silent: set[str] = set()
        self.driven: list[Twist] = []
        self._link = RosLink(domain_id, name="stand_in")
        node, own = self._link.node, f"/{ROBOT}/{{}}".format
        self._publishers = {
            "odom": node.create_publisher(Odometry, own("odom"), 10),
            "scan": node.create_publisher(LaserScan, own("scan"), qos_profile_sensor_data),
            "camera": node.create_publisher(CompressedImage, own("camera/compressed"), 1),
        }
        self._map = node.create_publisher(OccupancyGrid, "/map", qos.LATCHED)
        self._map.publish(wall_map())
        self._link.subscribe(Twist, own("cmd_vel"), self.driven.append, qos.EVENTS)
        odom = Odometry(child_frame_id="base_link")
        odom.header.frame_id = "map"  # as of a simulator that knows
        odom.pose.pose.position.x, odom.pose.pose.position.y = X, Y
        odom.pose.pose.orientation.z = math.sin(YAW / 2)
        odom.pose.pose.orientation.w = math.cos(YAW / 2)
        # The scanner faces right (scan.yaw is -90°), so 0 is x of the map; 1.118 m at -26.6°.
        away, turn = math.hypot(WALL[0] - X, WALL[1] - Y), math.atan2(WALL[1] - Y, WALL[0] - X)
        scan = LaserScan(angle_min=turn, angle_increment=0.1, range_min=0.1, range_max=8.0)
        scan.ranges = [away, math.inf, math.nan, 0.0]
        scan.header.frame_id = "laser"
        camera = CompressedImage(format="rgb8; jpeg compressed bgr8")
        camera.data = array.array("B", red_jpeg())
        self._messages: dict[str, Any] = {"odom": odom, "scan": scan, "camera": camera}
        node.create_timer(PERIOD, self._publish)
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._spin)
        self._thread.start()

    def _publish(self) -> None:
        for name, message in self._messages.items():
            if name not in self.silent:
                message.header.stamp = self._link.node.get_clock().now().to_msg()
                self._publishers[name].publish(message)

    def _spin(self) -> None:
        while not self._ending.is_set():
            self._link.spin(0.02)

    def close(self) -> None:
        self._ending.set()
        self._thread.join()
        self._link.close()


def wall_map() -> OccupancyGrid:
    """Return a map of 4 m by 3 m, of free cells and one that is occupied."""
    width, height = 8, 6
    grid = OccupancyGrid()
    grid.header.frame_id = "map"
    grid.info.width, grid.info.height, grid.info.resolution = width, height, CELL
    grid.info.origin.position.y = -1.0
    grid.info.origin.orientation.w = 1.0
    cells = [0] * (width * height)
    cells[int((WALL[1] + 1.0) / CELL) * width + int(WALL[0] / CELL)] = 100
    grid.data = array.array("b", cells)
    return grid


@pytest.fixture(scope="module")
def robot(home: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Robot, str]]:
    """Return a robot with its agent, and the address of a studio that shows them."""
    folder = tmp_path_factory.mktemp("robot")
    paths = [str(ROOT / "examples/diff_drive"), os.environ.get("PYTHONPATH", "")]
    with domain_ids.reserved() as number, pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join(paths))
        agent = [sys.executable, "-m", "hitab_agent.agent_main", "--ros-args"]
        agent += ["-r", f"__ns:=/{ROBOT}", "-p", "domain:=diff_drive.domain:DOMAIN"]
        agent += ["-p", f"state_dir:={folder}", "-p", f"scan.yaw:={-math.pi / 2}"]
        process = subprocess.Popen(agent)
        made = Robot(number)
        try:
            with RosLink(number) as link:
                SwarmClient(link, [ROBOT]).await_agent(ROBOT, SECONDS)
            with studio(folder / "log") as url:
                yield made, url
        finally:
            process.kill()
            process.wait()
            made.close()


@needs_browser
def test_a_robot_is_seen_on_its_map_with_its_camera_and_nothing_asks_for_a_world(robot, window):
    there, url = robot
    window.set_viewport_size({"width": 1280, "height": 720})
    person = Person(window, url)
    page = person.page
    person.click(f"agent-{ROBOT}")
    person.sees_field()
    assert person.place_of(ROBOT) == pytest.approx((X, Y), abs=1e-5)
    facing = "f => f.now.places[2]"
    assert page.evaluate(f"({facing})(studioField)") == pytest.approx(YAW, abs=1e-5)
    # The only return of the scan is at a corner of the only occupied cell.
    # Until the transforms have come, the scanner is where the parameters of the agent say.
    page.wait_for_function(
        """([x, y]) => {
          const { points } = studioField.robots;
          return points.length === 2 && Math.hypot(points[0] - x, points[1] - y) < 1e-3;
        }""",
        arg=WALL,
    )
    page.wait_for_function("studioField.robots.map?.canvas")
    page.wait_for_function(
        """([x, y]) => {
          const f = studioField, [px, py] = f.toScreen(x, y).map((p) => Math.round(p * f.ratio));
          const [r, g, b] = f.context.getImageData(px, py, 1, 1).data;
          return r + g + b < 200; // drawn in ink
        }""",
        arg=[WALL[0] + 0.4 * CELL, WALL[1] + 0.4 * CELL],
    )
    # Its camera, and how old each sensor's last message is.
    page.wait_for_function(
        """() => {
          const canvas = document.querySelector("#camera canvas");
          if (canvas?.width !== 64) return false;
          const [r, g] = canvas.getContext("2d").getImageData(30, 20, 1, 1).data;
          return r > 200 && g < 60;
        }"""
    )
    person.sees("camera-caption", "/robot_1/camera/compressed")
    page.wait_for_function(  # beside the keys, whenever both are drawn
        """() => {
          const [deck, camera] = [".deck", "#camera"].map(
            (at) => document.querySelector(at)?.getBoundingClientRect());
          return deck?.width && camera?.width && camera.right <= deck.left;
        }"""
    )
    for topic in ("odom", "scan", "camera/compressed"):
        person.sees(f"sensor-/{ROBOT}/{topic}", " s ago")
    page.evaluate(Axe().axe_script)
    wrong = page.evaluate("axe.run(document, {resultTypes: ['violations']})")["violations"]
    assert [(rule["id"], rule["nodes"][0]["html"]) for rule in wrong] == []
    # What needs a world is not offered, and a robot cannot be dragged.
    for name in ("pause", "step", "unplace", "snapshots"):
        assert page.locator(f'[data-test="{name}"]').count() == 0
    person.drags(ROBOT, X + 1.0, Y)
    page.focus("canvas#field")
    page.keyboard.press("ArrowRight")
    assert page.evaluate("studioField.handles.length") == 0
    assert person.place_of(ROBOT) == pytest.approx((X, Y), abs=1e-5)
    # It is commanded as any other.
    person.click("do-TurnLeft")
    person.sees("waits", "robot_1: waits to be armed: it has just started")
    person.click("arm")
    person.waits_until(lambda: any(v.angular.z > 0 for v in there.driven), "it turns", SECONDS)
    # A sensor that falls silent stops the robot, and what it saw is drawn no more.
    there.silent = {"scan", "camera"}
    person.sees("waits", f"sensor scan, /{ROBOT}/scan: silent")
    page.wait_for_function("studioField.robots.points.length === 0")
    there.silent = set()
    person.sees(
        "waits", "scan has no value, and the robot must not drive without it; that is over"
    )
    # A sensor of a starved robot may fall silent again; then the person re-arms it again.
    armed_for = ""

    def moves_again() -> bool:
        nonlocal armed_for
        waits = page.evaluate("document.querySelector('[data-test=waits]')?.innerText ?? ''")
        if waits != armed_for and "that is over" in waits:
            page.evaluate("document.querySelector('[data-test=arm]').click()")
        armed_for = waits
        return not waits

    person.waits_until(moves_again, "it may act", SECONDS)
    person.click("camera-caption")
    page.wait_for_selector("#camera canvas", state="hidden")
    # Nothing can be held at a breakpoint.
    person.click("new")
    person.type("new-name", "Turn")
    person.tick("feature-Bumped")
    person.click("begin")
    person.sees("mode", "Training")
    person.click("do-TurnLeft")
    person.click("tab-learned")
    person.sees("stops", "Say it at")
    assert page.locator(".message.bad").count() == 0
    assert person.complaints == []
