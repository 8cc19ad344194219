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
from pathlib import Path
from typing import Any

import pytest
from robot_desk import ROBOT, Desk
from sensor_msgs.msg import Joy

from hitab_core.operations import BeginTraining

UP, LEFT = b"\x1b[A", b"\x1b[D"
KEYS = {"Forward": b"1", "Stop": b"2", "TurnLeft": b"3"}
LB, A, RB, GUIDE = 4, 0, 5, 8  # of the mapping xbox
PRESS_S = 0.3


def is_halted(desk: Desk) -> bool:
    """Whether the agent does nothing that could drive the robot."""
    return list(desk.status.active_path) in ([], ["Start"])


def goes(desk: Desk) -> bool:
    """Whether the robot was last sent ahead."""
    return bool(desk.velocities) and desk.velocities[-1].linear.x > 0.05


@pytest.fixture
def training(desk: Desk) -> Desk:
    """The robot at rest, in a new training."""
    relay = f"/{ROBOT}/cmd_vel_teleop"
    desk.until(lambda: desk.link.node.count_subscribers(relay) > 0)
    desk.agents.do(ROBOT, BeginTraining("Wander", features=["RangeAhead"]))
    return desk


class Terminal:
    """`hitab drive` in a terminal of its own."""

    def __init__(self, desk: Desk, *arguments: str) -> None:
        self.desk = desk
        self.seen = ""
        self.pressed = b""
        self.screen, self.inner = pty.openpty()
        self.before = termios.tcgetattr(self.inner)
        self.process = subprocess.Popen(
            [sys.executable, "-m", "hitab_cli.main", "drive", *arguments],
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
def terminal(training: Desk) -> Iterator[Terminal]:
    terminal = Terminal(training)
    terminal.sees("3 TurnLeft")
    yield terminal
    terminal.close()


def test_keys_train_a_robot_and_drive_it_and_stop_it(desk, terminal):
    assert termios.tcgetattr(terminal.inner) != terminal.before
    terminal.press(KEYS["Forward"])
    terminal.sees("robot_1: Start -> Forward; Wander has 2 examples (1 default)")
    terminal.until(lambda: desk.moves(0.5))
    terminal.press(KEYS["TurnLeft"])
    terminal.sees('training "Wander": 4 examples (2 default); performs TurnLeft')
    terminal.press(b"u")
    terminal.sees("2 examples")
    terminal.until(lambda: desk.status.training.examples == 2 and desk.moves(0.5))
    terminal.press(b"z")
    terminal.sees('nothing is on the key "z"')

    # Driving by hand halts the agent first, so that nothing drives the robot on afterwards.
    desk.until(lambda: desk.moves(0.2), lambda: terminal.press(UP))
    desk.until(lambda: desk.status.mode == "training")
    assert is_halted(desk)
    terminal.sees("driven by hand: +0.20 m/s ahead")
    desk.until(desk.moves)
    desk.until(lambda: desk.moves(0.0, 0.8), lambda: terminal.press(LEFT))
    desk.until(desk.moves)

    # The emergency stop holds it, whatever is pressed.
    terminal.press(b" ")
    terminal.until(lambda: desk.switch.engaged)
    terminal.sees("EMERGENCY STOP by")
    terminal.press(KEYS["Forward"])
    terminal.sees("robot_1: stopped: emergency stop by")
    desk.velocities.clear()
    desk.until(lambda: len(desk.velocities) > 10, lambda: terminal.press(UP))
    assert {v.linear.x for v in desk.velocities} == {0.0}
    terminal.press(b"G")
    terminal.until(lambda: desk.has_fault("waits to be armed"))  # it has heard of the release
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
                [sys.executable, "-m", "hitab_cli.main", "joystick", ROBOT],
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
        there = "the joystick is connected"
        before = self.log.read_text().count(there)
        self.until(lambda: self.log.read_text().count(there) > before)


@pytest.fixture
def gamepad(training: Desk, tmp_path: Path) -> Iterator[Gamepad]:
    gamepad = Gamepad(training, tmp_path / "log")
    gamepad.until_there_again()
    yield gamepad
    gamepad.process.terminate()
    gamepad.process.wait()
    print(gamepad.log.read_text())
    training.link.node.destroy_publisher(gamepad.topic)


def test_a_gamepad_trains_a_robot_and_drives_it_while_its_switch_is_held(desk, gamepad):
    gamepad.press_until(lambda: gamepad.says("robot_1: Start -> Forward; Wander has"), A)
    gamepad.until(lambda: desk.moves(0.5))

    gamepad.joy.axes[1] = 0.5
    gamepad.press_until(lambda: goes(desk) and not desk.moves(0.5) and is_halted(desk))
    gamepad.hold()
    gamepad.until(desk.moves)

    gamepad.press_until(lambda: goes(desk))
    desk.until(desk.moves)  # the gamepad is lost
    desk.until(lambda: gamepad.says("the joystick is silent: driving by hand has stopped"))
    gamepad.hold(LB)
    gamepad.until_there_again()
    assert desk.moves(), "its switch has to be let go first"

    gamepad.press_until(lambda: goes(desk))
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
