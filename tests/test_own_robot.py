"""A robot of one's own, examples/diff_drive: trained by topics, and safe when something fails."""

import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from mentions import ROOT
from robot_desk import DOMAIN, EXAMPLE, ROBOT, Desk, desk_with, is_still

from hitab_client import SwarmError
from hitab_core import BehaviorLibrary, load_domain
from hitab_core.operations import BeginTraining, Command, Perform, SaveBehavior, Test
from hitab_robots.relay.velocity import SILENT_S

BROKEN = """
from dataclasses import replace
from diff_drive import domain

def broken(body, *targets):
    return 1 / 0

FEATURES = {**domain.DOMAIN.features, "RangeAhead": replace(
    domain.DOMAIN.features["RangeAhead"], read=broken)}
DOMAIN = replace(domain.DOMAIN, features=FEATURES)
"""
HULL = 0.2  # m


def obeys(desk: Desk, behavior: str) -> bool:
    """Whether a command is taken: it is refused until the agent has heard of all its sensors."""
    try:
        desk.agents.do(ROBOT, Command(behavior))
    except SwarmError:
        return False
    return True


def test_a_trained_robot_wanders_about_and_bumps_into_nothing(desk, monkeypatch):
    desk.agents.do(
        ROBOT, BeginTraining("Wander", features=["RangeAhead"], states=["Forward", "TurnLeft"])
    )
    desk.until(lambda: obeys(desk, "Forward"))
    desk.until(lambda: desk.free_ahead < 1.0)
    desk.agents.do(ROBOT, Command("TurnLeft"))
    desk.until(lambda: desk.free_ahead > 1.8)
    desk.agents.do(ROBOT, Command("Forward"))
    assert desk.agents.do(ROBOT, Test()).success
    desk.changes.clear()
    desk.until(lambda: desk.changes.count(("TurnLeft", "Forward")) >= 2)
    assert desk.changes[0] == ("Forward", "TurnLeft")
    assert desk.nearest > HULL
    assert desk.status.last_error == ""

    saved = desk.agents.do(
        ROBOT, SaveBehavior(description="Drive about, turning left before what is near.")
    )
    monkeypatch.syspath_prepend(str(EXAMPLE))
    wander = BehaviorLibrary(Path(saved.path).parent, load_domain(DOMAIN)).load()["Wander"]
    assert wander.labels == ("Forward", "TurnLeft")
    assert len(wander.examples) == 6
    # What was tested goes on.
    desk.changes.clear()
    desk.until(lambda: len(desk.changes) > 0)
    desk.agents.do(ROBOT, Perform())
    desk.until(desk.moves)


def test_in_training_too_a_silent_sensor_stops_the_robot_until_the_next_command(desk):
    no_value = 'feature "RangeAhead" has no value'
    desk.agents.do(ROBOT, BeginTraining("Turn", features=["RangeAhead"]))
    for commanded_to_stop in (True, False):
        desk.until(lambda: obeys(desk, "TurnLeft"))
        desk.until(lambda: not desk.moves())
        desk.robot.send_signal(signal.SIGSTOP)  # all of its sensors fall silent
        desk.until(lambda: desk.has_fault(no_value))
        desk.until(desk.moves)
        assert list(desk.status.active_path) == ["Start"]
        with pytest.raises(SwarmError, match=no_value):
            desk.agents.do(ROBOT, Command("TurnRight"))
        if commanded_to_stop:
            said = desk.hitab("demonstrate", ROBOT, "Stop")
            why = f"{ROBOT} stands still, but Stop was not recorded: {no_value}"
            assert f"{ROBOT} performs Stop; Turn has 2 examples (1 default); {why}" in said
            desk.until(lambda: list(desk.status.active_path) == ["Stop"])
        desk.robot.send_signal(signal.SIGCONT)
        desk.until(lambda: desk.has_fault("that is over"))
        assert f"`hitab arm {ROBOT}`" in desk.hitab("demonstrate", ROBOT, "TurnRight", status=1)
        desk.arm()
        desk.velocities.clear()
        desk.until_later(2.0)
        assert all(map(is_still, desk.velocities))
        assert desk.status.note.startswith("stands still")
    desk.agents.do(ROBOT, Command("TurnLeft"))
    desk.until(lambda: not desk.moves())
    assert not desk.status.note


def test_a_robot_whose_scanner_is_silent_does_not_drive_whatever_it_performs(desk):
    desk.perform("TurnLeft")
    desk.robot.send_signal(signal.SIGSTOP)
    desk.until(lambda: desk.has_fault("scan has no value, and the robot must not drive"))
    desk.until(desk.moves)
    desk.robot.send_signal(signal.SIGCONT)
    desk.until(lambda: desk.has_fault("that is over"))
    desk.arm()
    desk.until(lambda: not desk.moves())


def test_the_emergency_stop_holds_the_robot_until_it_is_released_and_re_armed(desk):
    desk.perform("TurnLeft")
    assert f"stand still: {ROBOT}\n" in desk.hitab("stop", "--reason", "a dog")
    desk.link.spin_until(lambda: False, 0.1)
    assert desk.moves()
    desk.until(lambda: desk.has_fault("a dog"))
    assert "a dog" in desk.status.stopped
    assert "a dog" in desk.hitab("status", "--check", status=1)
    desk.hitab("train", ROBOT, "Held")
    refused = desk.hitab("demonstrate", ROBOT, "TurnLeft", status=1)
    assert f"{ROBOT}: stopped: emergency stop by" in refused
    desk.hitab("demonstrate", ROBOT, "Stop")
    assert "but: stopped: emergency stop by" in desk.hitab("test", ROBOT)
    desk.hitab("discard", ROBOT)
    assert "but: stopped: emergency stop by" in desk.hitab("perform", ROBOT, "TurnLeft")
    refused = " ".join(desk.hitab("arm", ROBOT, status=1).split())
    assert f"{ROBOT} may not act again: emergency stop by" in refused
    assert desk.stays_where_it_is()
    assert f"released: {ROBOT}; robots wait for `hitab arm`" in desk.hitab("go")
    assert desk.stays_where_it_is()
    waits = desk.hitab("arm")
    assert f"{ROBOT}: waits to be armed: emergency stop by" in waits
    assert "hitab go" not in waits + desk.hitab("status")
    assert (
        desk.hitab("arm", "--all")
        == f"{ROBOT} may act in ROS domain {desk.link.node.context.get_domain_id()}\n"
    )
    desk.until(lambda: not desk.moves())
    desk.until(lambda: not desk.has_fault("stopped"))


@pytest.mark.parametrize("hangs", ["relay", "agent"])
def test_when_its_agent_or_relay_hangs_the_robot_stops_and_goes_on_only_once_re_armed(desk, hangs):
    desk.perform("TurnLeft")
    agent = psutil.Process(desk.agent.pid)
    process = agent if hangs == "agent" else agent.children()[0]
    process.suspend()
    desk.until(desk.moves)
    if hangs == "agent":
        desk.link.spin_until(lambda: False, 1.5 * SILENT_S)
        process.resume()
    else:
        desk.until(lambda: not process.is_running())  # it was replaced
    desk.until(lambda: desk.has_fault("waits to be armed"))
    assert desk.stays_where_it_is()
    desk.arm()
    desk.until(lambda: not desk.moves())


def test_a_robot_that_lost_its_odometry_on_its_way_goes_on_only_once_re_armed(desk):
    desk.perform("DriveTo(goal)")
    desk.robot.send_signal(signal.SIGSTOP)  # all of its sensors fall silent
    desk.until(lambda: desk.has_fault("without a value now: odom.x"))
    desk.until(desk.moves)
    desk.robot.send_signal(signal.SIGCONT)
    desk.until(lambda: desk.has_fault("waits to be armed: its behavior commands"))
    assert desk.stays_where_it_is()
    desk.arm()
    desk.until(lambda: not desk.moves())


def test_what_stands_for_nav2_drives_through_the_relay_as_the_page_says(desk):
    page = (ROOT / "docs/robots.md").read_text(encoding="utf-8")
    (command,) = re.findall(r"^    scripts/python (examples/nav2/.*)", page, re.MULTILINE)
    arguments = [sys.executable, *command.split()]
    with subprocess.Popen(arguments, cwd=ROOT, env=desk.environment) as controller:
        try:
            desk.until(lambda: desk.velocities and desk.velocities[-1].linear.x == 0.2)
            desk.hitab("stop")
            desk.until(desk.moves)
            assert desk.stays_where_it_is()
            assert not desk.has_fault("past the velocity_relay")
        finally:
            controller.kill()


def test_whoever_drives_a_robot_that_performs_nothing_is_not_disturbed(desk):
    desk.perform("TurnLeft")
    desk.agents.do(ROBOT, Perform())
    desk.until(desk.moves)
    quiet = time.monotonic()

    def nothing_is_sent() -> bool:
        nonlocal quiet
        if desk.velocities:
            desk.velocities.clear()
            quiet = time.monotonic()
        return time.monotonic() - quiet > 1.0

    desk.until(nothing_is_sent)


@pytest.mark.parametrize("lossy", [10], indirect=True)
def test_the_robot_stands_still_when_its_agent_is_killed_but_not_for_lost_datagrams(
    lossy, home, tmp_path
):
    """What came after a lost heartbeat was withheld until that was sent again."""
    with desk_with(tmp_path) as desk:
        desk.perform("TurnLeft")
        relay = psutil.Process(desk.agent.pid).children()[0]
        desk.velocities.clear()
        desk.until_later(10.0)
        assert relay.is_running()
        assert not any(map(is_still, desk.velocities))

        desk.agent.kill()
        desk.until(desk.moves)
        # Its relay ends too, and sends nothing but zeros until then.
        before = len(desk.velocities)
        desk.until(lambda: not relay.is_running())
        assert all(map(is_still, desk.velocities[before:]))


def test_a_mistake_in_a_domain_is_told_by_file_and_line_and_the_agent_lives_on(home, tmp_path):
    (tmp_path / "broken.py").write_text(BROKEN)
    with desk_with(tmp_path, "broken:DOMAIN") as desk:
        desk.agents.do(ROBOT, BeginTraining("Wander", features=["Bumped"]))
        desk.await_value("Bumped")
        desk.agents.do(ROBOT, BeginTraining("Wander", features=["RangeAhead"]))
        with pytest.raises(SwarmError, match=r"ZeroDivisionError in broken\.py:6: division by"):
            desk.agents.do(ROBOT, Command("Forward"))
        desk.agents.do(ROBOT, BeginTraining("Wander", features=["Bumped"]))
        desk.await_value("Bumped")
        assert desk.agents.do(ROBOT, Command("Stop")).status.training.examples == 2
