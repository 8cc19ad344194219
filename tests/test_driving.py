"""A person trains and drives a robot by keys in a terminal and by a gamepad, over real topics."""

import math
import os
import pty
import re
import select
import signal
import subprocess
import sys
import termios
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from arming import arm
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Joy

from hitab_client.domain_ids import reserved
from hitab_client.ros_link import RosLink
from hitab_client.swarm_client import SwarmClient
from hitab_ros import EmergencySwitch, qos

EXAMPLE = Path(__file__).parents[1] / "examples/diff_drive"
ROBOT = "robot_1"
SECONDS = 60.0
UP, LEFT = b"\x1b[A", b"\x1b[D"
KEYS = {"Forward": b"1", "Stop": b"2", "TurnLeft": b"3"}
LB, A, RB, GUIDE = 4, 0, 5, 8  # of the mapping xbox
PRESS_S = 0.3


@dataclass
class Desk:
    """A simulated robot with its agent, and somebody who looks on."""

    link: RosLink
    agents: SwarmClient
    switch: EmergencySwitch
    environment: dict[str, str]
    velocities: list[Twist] = field(default_factory=list)

    @property
    def status(self) -> Any:
        return self.agents.statuses[ROBOT]

    def until(self, condition: Callable[[], Any], each: Callable[[], Any] = lambda: None) -> None:
        deadline = time.monotonic() + SECONDS
        while not condition():
            assert time.monotonic() < deadline, "it did not happen in time"
            each()
            self.link.spin(0.02)

    def moves(self, ahead: float = 0.0, turn: float = 0.0) -> bool:
        """Whether the robot was last sent about this velocity."""
        if not self.velocities:
            return ahead == turn == 0.0
        last = self.velocities[-1]
        return abs(last.linear.x - ahead) < 1e-6 and abs(last.angular.z - turn) < 1e-6

    def goes(self) -> bool:
        """Whether the robot was last sent ahead."""
        return bool(self.velocities) and self.velocities[-1].linear.x > 0.05

    def is_halted(self) -> bool:
        """Whether the agent does nothing that could drive the robot."""
        return list(self.status.active_path) in ([], ["Start"])

    def train(self) -> None:
        """Begin a training anew, with the robot at rest."""
        self.agents.perform(ROBOT, "")
        self.agents.begin(ROBOT, "Wander", features=["RangeAhead"], discard=True)
        self.until(self.moves)


@pytest.fixture(scope="module")
def desk(home: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    """The robot, its agent and its relay, shared by the tests of this file."""
    with ExitStack() as stack:
        domain_id = stack.enter_context(reserved())
        environment = {
            **os.environ,
            "ROS_DOMAIN_ID": str(domain_id),
            "PYTHONPATH": f"{EXAMPLE}{os.pathsep}{os.environ.get('PYTHONPATH', '')}",
            "COLUMNS": "200",
            "LINES": "50",
            "TERM": "xterm",
        }

        def start(module: str, *arguments: str) -> None:
            named = ("--ros-args", "-r", f"__ns:=/{ROBOT}", *arguments)
            process = subprocess.Popen([sys.executable, "-m", module, *named], env=environment)
            stack.callback(process.wait)
            stack.callback(process.terminate)

        start("diff_drive.simulated_robot")
        state = tmp_path_factory.mktemp("state")
        domain = ("-p", "domain:=diff_drive.domain:DOMAIN", "-p", f"state_dir:={state}")
        start("hitab_agent.agent_main", *domain)
        link = stack.enter_context(RosLink(domain_id))
        desk = Desk(link, SwarmClient(link), EmergencySwitch(link.node), environment)
        link.subscribe(Twist, f"/{ROBOT}/cmd_vel", desk.velocities.append, qos.EVENTS)
        desk.agents.await_agent(ROBOT, SECONDS)
        relay = f"/{ROBOT}/cmd_vel_teleop"
        desk.until(lambda: link.node.count_subscribers(relay) > 0)
        arm(link, ROBOT)
        desk.until(lambda: not desk.status.faults)
        yield desk


class Terminal:
    """`hitab drive` in a terminal of its own."""

    def __init__(self, desk: Desk, *arguments: str) -> None:
        self.desk = desk
        self.seen = ""
        self.pressed = b""
        self.screen, self.inner = pty.openpty()
        self.before = termios.tcgetattr(self.inner)
        self.process = subprocess.Popen(
            [sys.executable, "-m", "hitab_bringup.main", "drive", *arguments],
            stdin=self.inner,
            stdout=self.inner,
            stderr=self.inner,
            env=desk.environment,
            start_new_session=True,
        )

    def press(self, key: bytes) -> None:
        self.pressed = key
        os.write(self.screen, key)

    def until(self, condition: Callable[[], Any]) -> None:
        """Wait for something; what is left out because it came late is pressed again."""
        known = self.late()

        def press_again() -> None:
            nonlocal known
            late = self.late()
            if late and late != known:
                self.press(self.pressed)
                known = late

        self.desk.until(condition, press_again)

    def late(self) -> list[str]:
        """Return what the terminal has last said about a key that came late."""
        return re.findall(r"left out: it was pressed [0-9.]+ s ago", self.read())[-1:]

    def read(self) -> str:
        while select.select([self.screen], [], [], 0)[0]:
            text = os.read(self.screen, 1 << 16).decode(errors="replace")
            self.seen += re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", text)
        return self.seen

    def sees(self, text: str) -> None:
        """Wait until the terminal has shown a text since it was last looked for."""
        self.until(lambda: text in self.read())
        self.seen = self.seen[self.seen.rindex(text) + len(text) :]

    def ends_with(self, status: int) -> None:
        self.desk.until(lambda: self.read() is None or self.process.poll() is not None)
        assert self.process.returncode == status
        assert "Traceback" not in self.read()
        assert termios.tcgetattr(self.inner) == self.before

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self.screen)
        os.close(self.inner)


@pytest.fixture
def terminal(desk: Desk) -> Iterator[Terminal]:
    desk.train()
    terminal = Terminal(desk)
    terminal.sees("3 TurnLeft")
    yield terminal
    desk.switch.set(False, "the test")
    terminal.close()


def test_keys_train_a_robot_and_drive_it_and_stop_it(desk, terminal):
    assert termios.tcgetattr(terminal.inner) != terminal.before
    terminal.press(KEYS["Forward"])
    terminal.sees("robot_1 performs Forward; Wander has 2 examples (1 default)")
    terminal.until(lambda: desk.moves(0.5))
    terminal.press(KEYS["TurnLeft"])
    terminal.sees('training "Wander": 4 examples (2 default); performs TurnLeft')
    terminal.press(b"u")
    terminal.sees("2 examples")
    terminal.until(lambda: desk.status.examples == 2 and desk.moves(0.5))
    terminal.press(b"z")
    terminal.sees('nothing is on the key "z"')

    # Driving by hand halts the agent first, so that nothing drives the robot on afterwards.
    desk.until(lambda: desk.moves(0.2), lambda: terminal.press(UP))
    desk.until(lambda: desk.status.mode == "training")
    assert desk.is_halted()
    terminal.sees("driven by hand: +0.20 m/s ahead")
    desk.until(desk.moves)
    desk.until(lambda: desk.moves(0.0, 0.8), lambda: terminal.press(LEFT))
    desk.until(desk.moves)

    # The emergency stop holds it, whatever is pressed.
    terminal.press(b" ")
    terminal.until(lambda: desk.switch.engaged)
    terminal.sees("EMERGENCY STOP by")
    terminal.press(KEYS["Forward"])
    terminal.until(lambda: list(desk.status.active_path) == ["Forward"])
    desk.velocities.clear()
    desk.until(lambda: len(desk.velocities) > 10, lambda: terminal.press(UP))
    assert {v.linear.x for v in desk.velocities} == {0.0}
    terminal.press(b"G")
    terminal.until(lambda: not desk.switch.engaged)
    terminal.press(b"R")
    terminal.sees("robot_1 may act")
    terminal.press(KEYS["Forward"])
    terminal.until(lambda: desk.moves(0.5))
    terminal.press(b".")
    terminal.sees("robot_1 performs nothing")
    terminal.until(desk.moves)
    terminal.press(b"?")
    terminal.sees("take over")
    os.killpg(terminal.process.pid, signal.SIGTERM)
    terminal.ends_with(143)


class Gamepad:
    """An Xbox gamepad as joy_node reports it, and `hitab joystick`, which listens."""

    def __init__(self, desk: Desk, log: Path) -> None:
        self.desk = desk
        self.log = log
        self.joy = Joy(axes=[0.0] * 8, buttons=[0] * 11)
        self.topic = desk.link.node.create_publisher(Joy, "/joy", 10, temporary=True)
        with log.open("w") as file:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "hitab_bringup.main", "joystick", ROBOT],
                stdout=file,
                stderr=file,
                env=desk.environment,
            )

    def tell(self) -> None:
        self.joy.header.stamp = self.desk.link.node.get_clock().now().to_msg()
        self.topic.publish(self.joy)

    def until(self, condition: Callable[[], Any]) -> None:
        """Wait for something, with the gamepad as it is."""
        self.desk.until(condition, self.tell)

    def hold(self, *buttons: int) -> None:
        self.joy.buttons = [int(number in buttons) for number in range(11)]

    def press_until(self, condition: Callable[[], Any], *buttons: int) -> None:
        """Hold the switch and press buttons, again and again, until something happens.

        Whoever is late may find the gamepad lost; then the switch has to be held anew.
        """
        phases = ((), (LB,), (LB, *buttons))

        def play() -> None:
            self.hold(*phases[int(time.monotonic() / PRESS_S) % 3])
            self.tell()

        self.desk.until(condition, play)

    def says(self, text: str) -> bool:
        return text in self.log.read_text()

    def until_there_again(self) -> None:
        """Wait until its messages count again."""
        there = "the joystick is there"
        before = self.log.read_text().count(there)
        self.until(lambda: self.log.read_text().count(there) > before)


@pytest.fixture
def gamepad(desk: Desk, tmp_path: Path) -> Iterator[Gamepad]:
    desk.train()
    gamepad = Gamepad(desk, tmp_path / "log")
    gamepad.until_there_again()
    yield gamepad
    desk.switch.set(False, "the test")
    gamepad.process.terminate()
    gamepad.process.wait()
    print(gamepad.log.read_text())
    desk.link.node.destroy_publisher(gamepad.topic)


def test_a_gamepad_trains_a_robot_and_drives_it_while_its_switch_is_held(desk, gamepad):
    gamepad.press_until(lambda: gamepad.says("robot_1 performs Forward; Wander has"), A)
    gamepad.until(lambda: desk.moves(0.5))

    gamepad.joy.axes[1] = 0.5
    gamepad.press_until(lambda: desk.goes() and not desk.moves(0.5) and desk.is_halted())
    gamepad.hold()
    gamepad.until(desk.moves)

    gamepad.press_until(desk.goes)
    desk.until(desk.moves)  # the gamepad is lost
    desk.until(lambda: gamepad.says("the joystick is silent: driving by hand has stopped"))
    gamepad.hold(LB)
    gamepad.until_there_again()
    assert desk.moves(), "its switch has to be let go first"

    gamepad.press_until(desk.goes)
    gamepad.joy.axes = gamepad.joy.axes[:2]
    gamepad.until(lambda: gamepad.says("the joystick has 2 axes, but the mapping xbox uses 8"))
    gamepad.until(desk.moves)
    gamepad.joy.axes = [math.nan] * 8
    for number in range(500):  # a storm from a broken contact
        gamepad.hold(LB, *([A] if number % 2 else []))
        gamepad.tell()
    gamepad.until(lambda: gamepad.says("an axis of the joystick is not a number"))
    assert desk.moves()
    gamepad.press_until(lambda: desk.switch.engaged, RB)

    gamepad.joy.axes = [0.0] * 8
    gamepad.hold()
    gamepad.until_there_again()
    gamepad.press_until(lambda: not desk.switch.engaged, GUIDE)
