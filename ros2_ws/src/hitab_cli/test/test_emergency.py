"""The command-line emergency stop reaches all robots and worlds, and reports correctly."""

import threading
from pathlib import Path

import pytest
import rclpy
from hitab_msgs.msg import StopState
from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions

from hitab_cli.main import make_app
from hitab_cli.verbs.perform import emergency_verbs as emergency
from hitab_client import RunFolder, RunRecord, domain_ids, run_folder, swarm_choice
from hitab_ros import KnownStops, Stop, qos
from hitab_ros.nodes.guarded_node import GuardedNode


@pytest.fixture(autouse=True)
def domain_id(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    with domain_ids.reserved() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        yield number


@pytest.fixture
def swarms(monkeypatch):
    """Return a function that sets the registry's swarms, with one robot each."""

    def up(*records):
        there = [
            (
                RunFolder(Path(name)),
                RunRecord(name, "", number, "", ("robot_1",), False, 0, "", name),
            )
            for name, number in records
        ]
        for module in (run_folder, swarm_choice):
            monkeypatch.setattr(module, "running_swarms", lambda: iter(there))

    return up


def hitab(capfd, *arguments):
    """Run the command; return its exit status and what it prints."""
    capfd.readouterr()
    with pytest.raises(SystemExit) as ended:
        make_app()(list(arguments))
    printed = capfd.readouterr()
    return ended.value.code, printed.out, " ".join(printed.err.split())


class Field:
    """Robots, played by nodes that are spun in the background."""

    def __init__(self, domain_id):
        self.context = Context()
        rclpy.init(
            context=self.context,
            domain_id=domain_id,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        self.executor = EventsExecutor(context=self.context)
        self.moving = set()
        self.ends = threading.Event()
        self.thread = threading.Thread(target=self._spin)

    def _spin(self):
        while not self.ends.is_set():
            self.executor.spin_once(timeout_sec=0.05)

    def node(self, robot):
        node = GuardedNode("velocity_relay", namespace=f"/{robot}", context=self.context)
        self.executor.add_node(node)
        return node

    def robot(self, name):
        return Stop(self.node(name), lambda: name not in self.moving)

    def close(self):
        self.ends.set()
        self.thread.join()
        for node in list(self.executor.get_nodes()):
            self.executor.remove_node(node)
            node.destroy_node()
        self.executor.shutdown()
        self.context.try_shutdown()


@pytest.fixture
def field(domain_id, monkeypatch):
    monkeypatch.setattr(emergency, "ANSWER_S", 5.0)
    field = Field(domain_id)
    yield field
    field.close()


@pytest.fixture
def other_field():
    with domain_ids.reserved() as number:
        field = Field(number)
        yield field
        field.close()


def test_robots_are_stopped_and_released_and_re_armed_though_there_is_no_agent(
    field, domain_id, capfd
):
    one, two = field.robot("robot_1"), field.robot("red/robot_2")
    field.thread.start()
    status, out, _ = hitab(capfd, "stop", "--reason", "a dog")
    assert (status, out) == (0, "stand still: red/robot_2, robot_1\n")
    assert one.switch.engaged
    assert two.switch.known.who.endswith(" (a dog)")
    status, _, err = hitab(capfd, "arm", "robot_1")
    assert status == 1
    assert "robot_1 may not act again: emergency stop by" in err
    status, out, _ = hitab(capfd, "go")
    assert out == "released: red/robot_2, robot_1; robots wait for `hitab arm`\n"
    assert one.machine.why
    there = f"in ROS domain {domain_id}"
    assert hitab(capfd, "arm", "/red/robot_2")[1] == f"/red/robot_2 may act {there}\n"
    assert one.machine.why
    assert not two.machine.why
    waits = hitab(capfd, "arm")[1]
    assert waits == (
        "robot_1: waits to be armed: it has just started\n"
        "  let robot_1 act again: `hitab arm robot_1`\n"
    )
    assert hitab(capfd, "arm", "--all")[1] == f"robot_1 may act {there}\n"
    assert not one.machine.why
    assert hitab(capfd, "arm")[1] == f"no robot waits {there}\n"


def test_a_stop_names_each_robot_that_has_not_confirmed_to_stand_still(field, capfd):
    field.robot("robot_1")
    field.robot("robot_2")
    field.moving.add("robot_2")
    # The relay of one robot already hangs: only its agent can be found.
    field.node("robot_3").create_publisher(StopState, "agent_heartbeat", qos.STREAM)
    field.thread.start()
    status, out, err = hitab(capfd, "stop", "--wait", "5")
    assert (status, out) == (1, "")
    progress, _, outcome = err.partition("not confirmed: ")
    assert "waiting for" in progress
    assert "robot_2 (still moves)" in outcome
    assert "robot_3 (does not answer)" in outcome
    assert "robot_1 (" not in outcome
    field.moving.clear()
    outcome = hitab(capfd, "stop", "--wait", "5")[2].partition("not confirmed: ")[2]
    assert "robot_3 (does not answer)" in outcome
    assert "robot_2 (" not in outcome


def test_a_robot_that_has_not_heard_the_stop_is_stopped_by_the_next_message(
    field, capfd, monkeypatch
):
    heard = []
    read = KnownStops.of_texts

    def lose_the_first(*texts: list[str]) -> KnownStops:
        heard.append(texts)
        return KnownStops() if len(heard) < 3 else read(*texts)

    monkeypatch.setattr(KnownStops, "of_texts", lose_the_first)
    robot = field.robot("robot_1")
    field.thread.start()
    assert hitab(capfd, "stop")[0] == 0
    assert robot.switch.engaged
    assert len(robot.switch.known.stops) == 1, "the same stop is said again"


def test_a_stop_that_nobody_heard_is_an_error(domain_id, capfd):
    status, out, err = hitab(capfd, "stop", "--wait", "0.1")
    assert (status, out) == (1, "")
    assert "the stop was not heard: no robot and no simulated world answers in ROS domain" in err
    assert f"{domain_id}; use the robots' own switches" in err


def test_arming_acts_in_the_swarm_that_is_meant_and_stopping_in_all(
    field, other_field, swarms, capfd, monkeypatch
):
    here, there = field.context.get_domain_id(), other_field.context.get_domain_id()
    one, other = field.robot("robot_1"), other_field.robot("robot_1")
    field.thread.start()
    other_field.thread.start()
    swarms(("ants", here), ("bees", there))
    both = f"robot_1 in ROS domain {min(here, there)}, robot_1 in ROS domain {max(here, there)}"
    assert hitab(capfd, "stop")[1] == f"stand still: {both}\n"
    assert hitab(capfd, "go")[1] == f"released: {both}; robots wait for `hitab arm`\n"
    assert hitab(capfd, "arm", "robot_1")[1] == f"robot_1 may act in ROS domain {here}\n"
    assert other.machine.why
    assert hitab(capfd, "arm", "--all")[1] == f"no robot waits in ROS domain {here}\n"
    assert other.machine.why
    monkeypatch.delenv("ROS_DOMAIN_ID")
    for which in ("robot_1", "--all"):
        status, _, err = hitab(capfd, "arm", which)
        assert status == 1
        assert "several swarms are up; choose one with --swarm NAME" in err
    assert other.machine.why
    out = hitab(capfd, "arm", "--all", "--swarm", "bees")[1]
    assert out == f"robot_1 may act in ROS domain {there}\n"
    assert not one.machine.why
    assert not other.machine.why


def test_a_robot_of_another_swarm_in_the_same_domain_is_not_armed(field, domain_id, swarms, capfd):
    field.robot("robot_1")
    stranger = field.robot("red/robot_1")
    field.thread.start()
    swarms(("ants", domain_id))
    status, _, err = hitab(capfd, "arm", "red/robot_1")
    assert status == 1
    assert "red/robot_1 is not in this swarm (known: robot_1" in err
    assert hitab(capfd, "arm", "--all")[1] == f"robot_1 may act in ROS domain {domain_id}\n"
    assert stranger.machine.why


def test_a_robot_that_was_out_of_reach_obeys_when_it_is_back_though_the_stop_is_old(
    field, capfd, monkeypatch
):
    """The command keeps publishing the stop until all confirm, however long that takes."""
    monkeypatch.setattr(emergency, "ANSWER_S", 0.2)
    comes_back = threading.Event()
    monkeypatch.setattr(
        emergency.console,
        "note",
        lambda text: (
            "not confirmed" in text
            and not comes_back.is_set()
            and (comes_back.set(), field.robot("robot_1"), field.thread.start())
        ),
    )
    assert hitab(capfd, "stop")[:2] == (0, "stand still: robot_1\n")
    assert comes_back.is_set()
