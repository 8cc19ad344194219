"""The emergency stop from the command line reaches whatever acts, and says the truth about it."""

import threading

import pytest
import rclpy
from hitab_msgs.msg import EmergencyState, StopState
from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions

from hitab_bringup.main import make_app
from hitab_bringup.verbs import emergency
from hitab_client import domain_ids
from hitab_ros import EmergencySwitch, Stop, qos
from hitab_ros.guarded_node import GuardedNode


@pytest.fixture(autouse=True)
def domain_id(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    with domain_ids.reserved() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        yield number


def hitab(capfd, *arguments):
    """Run the command; return its exit status and what it prints."""
    capfd.readouterr()
    with pytest.raises(SystemExit) as ended:
        make_app()(list(arguments))
    told = capfd.readouterr()
    return ended.value.code, told.out, " ".join(told.err.split())


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


@pytest.fixture
def field(domain_id, monkeypatch):
    monkeypatch.setattr(emergency, "CONFIRM_S", 5.0)
    field = Field(domain_id)
    yield field
    field.ends.set()
    field.thread.join()
    for node in list(field.executor.get_nodes()):
        field.executor.remove_node(node)
        node.destroy_node()
    field.executor.shutdown()
    field.context.try_shutdown()


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
    assert waits.startswith("robot_1: stopped: emergency stop by")
    assert waits.endswith("that is over (hitab arm robot_1)\n")
    assert hitab(capfd, "arm", "--all")[1] == f"robot_1 may act {there}\n"
    assert not one.machine.why
    assert hitab(capfd, "arm")[1] == f"no robot waits {there}\n"


def test_a_stop_names_each_robot_that_has_not_confirmed_to_stand_still(field, capfd):
    field.robot("robot_1")
    field.robot("robot_2")
    field.moving.add("robot_2")
    # One whose relay hangs from before: only its agent can be found.
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
    take = EmergencySwitch._hear_state

    def lose_the_first(switch: EmergencySwitch, message: EmergencyState) -> None:
        heard.append(message)
        if len(heard) > 2:
            take(switch, message)

    monkeypatch.setattr(EmergencySwitch, "_hear_state", lose_the_first)
    robot = field.robot("robot_1")
    field.thread.start()
    assert hitab(capfd, "stop")[0] == 0
    assert robot.switch.engaged
    assert len(robot.switch.known.stops) == 1, "the same stop is said again"


def test_a_stop_that_nobody_heard_is_an_error(domain_id, capfd):
    status, out, err = hitab(capfd, "stop", "--wait", "0.1")
    assert (status, out) == (1, "")
    assert "nobody heard it: no robot and no simulated world answers in ROS domain" in err
    assert f"{domain_id}; use the robots' own switches" in err
