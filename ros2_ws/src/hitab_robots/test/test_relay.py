"""The relay between an agent and its robot's base, as nodes on topics."""

import json
import math
import os
import subprocess
import sys
import time

import pytest
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist, TwistStamped
from hitab_msgs.action import Perform
from hitab_msgs.msg import EmergencyStop, StopState
from hitab_msgs.srv import Arm
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.experimental import EventsExecutor
from rclpy.parameter import Parameter
from rclpy.task import Future

from hitab_core import HitabError, VocabularyError
from hitab_robots.relay.velocity_relay import STOP_FILE, VelocityRelay
from hitab_robots.settings import AGENT_VELOCITY_TOPIC, BASE_TOPIC, HEARTBEAT, ODOMETRY_TOPIC
from hitab_ros import EmergencySwitch, KnownStops, make_node, names, qos
from hitab_ros.testing import context_of_its_own, spin_until

ROBOT = "/robot_1"


class Bench:
    """A relay between an agent and a base, both played by the test."""

    def __init__(self, context, **parameters):
        self.context = context
        self.executor = EventsExecutor(context=context)
        self.sent, self.finished = [], []
        self.stamped = parameters.get("enable_stamped_cmd_vel", False)
        self.peer = self.add(make_node("peer", namespace=ROBOT, context=context))
        self.start_base()
        self.commands = self.peer.create_publisher(TwistStamped, AGENT_VELOCITY_TOPIC, 1)
        self.by_hand = self.peer.create_publisher(TwistStamped, names.TELEOP, 1)
        self.heartbeats = self.peer.create_publisher(StopState, HEARTBEAT, qos.STREAM)
        self.arming = self.peer.create_client(Arm, names.ARM)
        self.peer.create_subscription(StopState, names.STOP_STATE, self._hear_state, qos.STREAM)
        self.odometry = self.peer.create_publisher(Odometry, ODOMETRY_TOPIC, 10)
        self.lives, self.causes, self.state = True, [], None
        self.switch = EmergencySwitch(self.peer)
        self.start(**parameters)
        self.arm()

    def start_base(self):
        kind = TwistStamped if self.stamped else Twist
        self.base = self.peer.create_subscription(
            kind, BASE_TOPIC, self._hear, 100, temporary=True
        )

    def start(self, **parameters):
        given = [Parameter(name, value=value) for name, value in parameters.items()]
        self.relay = self.add(
            VelocityRelay(
                lambda: self.finished.append(1),
                namespace=ROBOT,
                context=self.context,
                parameter_overrides=given,
            )
        )
        topics = (self.commands, self.by_hand)
        self.until(lambda: all(topic.get_subscription_count() > 0 for topic in topics))

    def add(self, node):
        self.executor.add_node(node)
        return node

    def end_relay(self):
        self.executor.remove_node(self.relay)
        self.relay.destroy_node()

    def _hear(self, message):
        twist = message.twist if self.stamped else message
        self.sent.append((twist.linear.x, twist.linear.y, twist.angular.z))

    def _hear_state(self, message):
        self.state = message

    def until(self, condition, each=lambda: None):
        due = 0.0

        def give_sign():
            nonlocal due
            if time.monotonic() < due:
                return  # the nodes share one executor, which must keep up
            due = time.monotonic() + 0.03
            if self.lives:
                self.heartbeats.publish(StopState(causes=self.causes, state=StopState.STOPPED))
            each()

        spin_until(self.executor, condition, give_sign)

    def has(self, state, *causes):
        return (
            self.state is not None
            and self.state.state == state
            and all(any(cause in text for text in self.state.causes) for cause in causes)
        )

    def arm(self, each=lambda: None):
        """Let the robot act again, and return why it may not."""
        self.state = None
        self.until(lambda: self.has(StopState.STOPPED), each)
        answer = self.arming.call_async(Arm.Request(stop=self.state.stop))
        self.until(answer.done, each)
        return answer.result().message

    def drive(self, ahead, turn=0.0, by_hand=False):
        command = TwistStamped()
        command.twist.linear.x, command.twist.angular.z = ahead, turn
        (self.by_hand if by_hand else self.commands).publish(command)

    def until_it_moves(self):
        self.sent.clear()
        self.until(lambda: any(v[0] > 0.1 for v in self.sent), lambda: self.drive(0.2))

    def stands_until_armed(self):
        """Check that the robot moves once it is re-armed, and not before."""
        self.sent.clear()
        cycles = []
        self.until(lambda: len(cycles) > 20, lambda: cycles.append(self.drive(0.2)))
        assert not any(velocity[0] for velocity in self.sent)
        assert self.arm(lambda: self.drive(0.2)) == ""
        self.until_it_moves()

    def until_it_stands(self, each=lambda: None):
        self.sent.clear()
        self.until(lambda: self.sent and self.sent[-1] == (0.0, 0.0, 0.0), each)


@pytest.fixture
def bench(request, tmp_path):
    with context_of_its_own() as context:
        parameters = {"state_dir": str(tmp_path), **getattr(request, "param", {})}
        bench = Bench(context, **parameters)
        yield bench
        for node in list(bench.executor.get_nodes()):
            bench.executor.remove_node(node)
            node.destroy_node()
        bench.executor.shutdown()


@pytest.mark.parametrize(
    "bench", [{}, {"enable_stamped_cmd_vel": True}], ids=["Twist", "TwistStamped"], indirect=True
)
def test_what_the_agent_commands_passes_and_its_silence_stops_the_robot(bench):
    bench.until_it_moves()
    bench.until_it_stands()


def test_limits_are_parameters(bench):
    bench.end_relay()
    bench.start(max_velocity=[0.15, 0.0, 0.5], max_accel=[9.0, 0.0, 9.0])
    bench.arm()
    bench.sent.clear()
    bench.until(lambda: (0.15, 0.0, -0.5) in bench.sent, lambda: bench.drive(2.0, -2.0))
    assert max(velocity[0] for velocity in bench.sent) == 0.15
    for name, value, error, why in (
        ("max_accel", [1.0], VocabularyError, "max_accel of a drive"),
        ("cmd_vel_timeout", 0.0, HitabError, "cmd_vel_timeout is 0; it must be above 0"),
    ):
        given = [Parameter(name, value=value)]
        with pytest.raises(error, match=why):
            VelocityRelay(context=bench.context, parameter_overrides=given)


def test_nothing_that_is_no_number_passes_and_the_robot_waits_to_be_re_armed(bench):
    bench.until_it_moves()
    bench.until_it_stands(lambda: bench.drive(math.nan, math.inf))
    assert "the agent commands (nan, 0.0, inf)" in bench.state.why
    bench.stands_until_armed()
    assert all(map(math.isfinite, (number for velocity in bench.sent for number in velocity)))


def test_a_person_drives_through_the_relay_within_its_limits_and_counts_before_the_agent(bench):
    def both():
        bench.drive(0.4)
        bench.drive(-9.0, by_hand=True)

    bench.until(lambda: bench.sent and bench.sent[-1][0] == -0.5, both)
    bench.until_it_moves()
    bench.until_it_stands()
    bench.switch.set(True, "ann")
    bench.until_it_stands(lambda: bench.drive(0.2, by_hand=True))
    bench.sent.clear()
    bench.until(lambda: len(bench.sent) > 20, lambda: bench.drive(0.2, by_hand=True))
    assert {*bench.sent} == {(0.0, 0.0, 0.0)}


def test_an_emergency_stops_the_robot_though_its_agent_drives_on(bench):
    bench.until_it_moves()
    bench.switch.set(True, "ann", "a dog")
    bench.until_it_stands(lambda: bench.drive(0.2))
    bench.sent.clear()
    bench.until(lambda: len(bench.sent) > 20, lambda: bench.drive(0.2))
    assert {*bench.sent} == {(0.0, 0.0, 0.0)}
    assert "emergency stop by ann (a dog)" in bench.arm(lambda: bench.drive(0.2))
    bench.switch.set(False, "ann")
    bench.stands_until_armed()


def test_a_publisher_that_latches_nothing_stops_the_robot(bench):
    bench.until_it_moves()
    plain = bench.peer.create_publisher(EmergencyStop, names.EMERGENCY_STOP, 10)
    bench.until(plain.get_subscription_count, lambda: bench.drive(0.2))
    plain.publish(EmergencyStop(engaged=True, by="me"))
    bench.until(lambda: bench.has(StopState.STOPPED, "by me"), lambda: bench.drive(0.2))


def test_a_robot_whose_agent_hung_waits_to_be_re_armed(bench):
    bench.until_it_moves()
    bench.lives = False
    bench.until(lambda: bench.has(StopState.STOPPED, "no sign of life"), lambda: bench.drive(0.2))
    assert "no sign of life" in bench.arm(lambda: bench.drive(0.2))
    bench.lives = True
    bench.until(lambda: not bench.state.causes)
    bench.stands_until_armed()


def test_a_robot_whose_agent_cannot_act_waits_to_be_re_armed(bench):
    bench.until_it_moves()
    bench.causes = ["no scan"]
    bench.until(lambda: bench.has(StopState.STOPPED, "no scan"), lambda: bench.drive(0.2))
    bench.causes = []
    bench.until(lambda: not bench.state.causes)
    bench.stands_until_armed()


def test_a_robot_whose_base_was_started_again_waits_to_be_re_armed(bench):
    def start_base():
        base = bench.add(make_node("base", namespace=ROBOT, context=bench.context))
        base.create_subscription(Twist, BASE_TOPIC, ignore, 10)
        return base

    base = start_base()
    bench.until(lambda: bench.relay.count_subscribers(BASE_TOPIC) == 2)
    bench.until_it_moves()
    bench.executor.remove_node(base)
    base.destroy_node()
    bench.until(lambda: bench.relay.count_subscribers(BASE_TOPIC) == 1)
    bench.until_it_moves()
    start_base()
    bench.until(
        lambda: "/robot_1/base, subscribed to" in bench.state.why, lambda: bench.drive(0.2)
    )
    bench.stands_until_armed()


def test_a_robot_that_lost_its_base_waits_to_be_re_armed(bench):
    bench.until_it_moves()
    bench.peer.destroy_subscription(bench.base)
    missing = "no base subscribes to /robot_1/cmd_vel"
    bench.until(lambda: bench.has(StopState.STOPPED, missing), lambda: bench.drive(0.2))
    assert missing in bench.arm(lambda: bench.drive(0.2))
    bench.start_base()
    bench.until(lambda: not bench.state.causes)
    bench.stands_until_armed()


class Server:
    """An action server that carries out each goal until it is canceled."""

    def __init__(self, bench):
        self.running = []
        self.bench = bench
        self.server = ActionServer(
            bench.peer,
            Perform,
            "fly",
            self.execute,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
        )
        self.client = ActionClient(bench.peer, Perform, "fly")
        self.agent = bench.peer.create_publisher(DiagnosticStatus, names.GOALS, qos.LATCHED)

    async def execute(self, goal):
        self.running.append(goal)
        await Future(executor=self.bench.executor)

    def fly(self):
        """Have it take a goal; return the goal."""
        before = len(self.running)
        self.client.send_goal_async(Perform.Goal())
        self.bench.until(lambda: len(self.running) > before)
        return self.running[-1]

    def tell_of(self, goal):
        """Say that a goal is the agent's."""
        told = [KeyValue(key="/robot_1/fly", value=bytes(goal.goal_id.uuid).hex())]
        self.agent.publish(DiagnosticStatus(values=[*told, KeyValue(key="/x", value="ab")]))


@pytest.mark.parametrize("stop", ["silence", "emergency", "death"])
def test_goals_of_an_agent_that_cannot_cancel_them_are_canceled(bench, stop, monkeypatch):
    bench.end_relay()
    bench.start(max_velocity=[0.0, 0.0, 0.0], agent_pid=os.getppid())
    server = Server(bench)
    others, agents = server.fly(), server.fly()
    bench.until(server.agent.get_subscription_count)
    server.tell_of(agents)
    assert bench.arm() == "", "it has no base, and needs none"
    assert bench.relay.count_publishers(BASE_TOPIC) == 0
    if stop == "emergency":
        bench.switch.set(True, "ann")
        bench.until(lambda: bench.has(StopState.STOPPED, "ann"))
        assert not agents.is_cancel_requested, "that is the agent's, as long as it lives"
    if stop == "death":
        monkeypatch.setattr(os, "getppid", lambda: 1)
    else:
        bench.lives = False
    bench.until(lambda: agents.is_cancel_requested)
    if stop == "death":
        assert not bench.finished
        server.tell_of(others)  # they are of an agent that was started since
        bench.until(lambda: bench.finished)
    assert not others.is_cancel_requested


def ignore(message):
    """Be subscribed."""


def test_a_robot_that_moves_has_not_stopped_whatever_it_was_told(bench):
    def slide():
        message = Odometry()
        message.twist.twist.linear.x = 0.3
        bench.odometry.publish(message)

    bench.switch.set(True, "ann")
    bench.until(lambda: bench.has(StopState.STOPPING, "by ann"), slide)
    bench.switch.set(False, "ann")
    bench.until(lambda: not bench.state.causes, slide)
    answer = bench.arming.call_async(Arm.Request())
    bench.until(answer.done, slide)
    assert answer.result().message == "it still moves"
    assert bench.arm() == ""


def test_a_relay_that_is_started_again_still_holds_the_robot(bench, tmp_path):
    bench.switch.set(True, "ann")
    file = tmp_path / "robot_1" / STOP_FILE
    bench.until(file.exists)
    bench.end_relay()
    bench.switch.known = KnownStops()
    bench.start(state_dir=str(tmp_path))
    bench.until(lambda: bench.switch.engaged)
    bench.until_it_stands(lambda: bench.drive(0.2))
    bench.switch.set(False, "ann")
    bench.until(lambda: not json.loads(file.read_text())["stops"])
    bench.stands_until_armed()


def test_a_damaged_file_holds_the_robot(bench, tmp_path):
    bench.end_relay()
    (tmp_path / "robot_1").mkdir(exist_ok=True)
    (tmp_path / "robot_1" / STOP_FILE).write_text("{")
    bench.start(state_dir=str(tmp_path))
    bench.until(lambda: bench.switch.engaged)
    assert "cannot be read" in bench.switch.known.who


def test_a_relay_whose_agent_is_gone_stops_the_robot_and_ends(bench):
    bench.end_relay()
    bench.start(agent_pid=1 << 30)  # nobody's
    bench.sent.clear()
    bench.until(lambda: bench.finished, lambda: bench.drive(0.2))
    assert {*bench.sent} == {(0.0, 0.0, 0.0)}


def test_a_relay_that_ends_stops_the_robot(bench):
    bench.until_it_moves()
    bench.end_relay()
    bench.until(lambda: bench.sent[-1] == (0.0, 0.0, 0.0))


def test_a_relay_loads_no_agent():
    # It guards the robot from its first moment on, and each robot runs one.
    loaded = "import sys, hitab_robots.relay.velocity_relay\n"
    loaded += "print('hitab_agent.node.agent_node' in sys.modules)"
    assert subprocess.check_output([sys.executable, "-c", loaded], text=True) == "False\n"
