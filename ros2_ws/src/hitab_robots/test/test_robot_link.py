"""The link of an agent to its robot; the test plays the robot and the engine of the agent."""

import math
from types import SimpleNamespace

import pytest
import rclpy
from geometry_msgs.msg import PointStamped, Twist, TwistStamped
from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan

from hitab_core import Domain, Repertoire
from hitab_robots import Robot, RobotLink, Scan, Sector, motion, nearest_range
from hitab_robots.relay import relay_process
from hitab_robots.relay.velocity_relay import VelocityRelay
from hitab_robots.settings import AGENT_VELOCITY_TOPIC, BASE_TOPIC
from hitab_ros import GuardedNode, make_node
from hitab_ros.messages.stamps import as_time
from hitab_ros.testing import context_of_its_own, spin_until

ROBOT = Robot((Scan(sectors=(Sector("ahead", width=0.2),)),))


class Desk:
    """An agent's node with a link, and its robot."""

    def __init__(self, context, body=ROBOT, remaps=(), **parameters):
        self.executor = EventsExecutor(context=context)
        given = {"relay": False, "rate": 50.0, **parameters}
        self.node = GuardedNode(
            "agent",
            namespace="/robot_1",
            context=context,
            cli_args=["--ros-args", *(word for remap in remaps for word in ("-r", remap))],
            parameter_overrides=[Parameter(k, value=v) for k, v in given.items()],
        )
        domain = Domain.of(
            "test",
            "1",
            body,
            behaviors=(motion("Forward", ahead=0.2), motion("Stop")),
            features=(nearest_range("RangeAhead", "scan.ahead"),),
        )
        self.node.agent = SimpleNamespace(domain=domain, repertoire=Repertoire(domain))
        self.node.settings = SimpleNamespace(state_dir="", swarm="")
        self.node.stands, self.node.stop_changed = lambda: True, lambda: None
        self.robot = make_node("robot", namespace="/robot_1", context=context)
        for node in (self.node, self.robot):
            self.executor.add_node(node)
        self.scans = self.robot.create_publisher(
            LaserScan, "/scan" if remaps else "scan", qos_profile_sensor_data, temporary=True
        )
        self.percepts, self.action = [], ()
        self.relay = None
        self.link = RobotLink(self.node, "world", self._tick)

    def _tick(self, percept):
        self.percepts.append(dict(zip(ROBOT.values, percept.values, strict=True)))
        return self.action, ""

    def start_relay(self, **parameters):
        given = [Parameter(name, value=value) for name, value in parameters.items()]
        self.relay = VelocityRelay(
            namespace="/robot_1", context=self.node.context, parameter_overrides=given
        )
        self.executor.add_node(self.relay)

    def hear_velocities(self):
        velocities = []
        self.robot.create_subscription(TwistStamped, AGENT_VELOCITY_TOPIC, velocities.append, 10)
        return velocities

    def scan(self, *ranges, age=0.0, stamp=None, range_max=9.0):
        """Publish a scan whose first ray is ahead in its own frame, and the second at its left."""
        message = LaserScan(
            angle_increment=math.pi / 2, range_min=0.1, range_max=range_max, ranges=ranges
        )
        if stamp is None:
            stamp = self.robot.get_clock().now().nanoseconds - int(age * 1e9)
        message.header.stamp = as_time(stamp)
        self.scans.publish(message)

    def until(self, condition, each=lambda: None):
        spin_until(self.executor, condition, each)

    def reads(self, value):
        """Whether the last percept has this range ahead."""
        found = self.percepts[-1]["scan.ahead.range"] if self.percepts else None
        return found is not None and found == pytest.approx(value, nan_ok=True)

    def has_fault(self, text):
        return any(text in fault for fault in self.node.guard.faults.texts())


@pytest.fixture
def desk(request):
    with context_of_its_own() as context:
        desk = Desk(context, **getattr(request, "param", {}))
        yield desk
        for node in filter(None, (desk.relay, desk.node, desk.robot)):
            desk.executor.remove_node(node)
            node.destroy_node()
        desk.executor.shutdown()


@pytest.mark.parametrize(
    "desk", [{"remaps": ["scan:=/scan"], "scan.yaw": -math.pi / 2}], indirect=True
)
def test_what_a_sensor_says_is_perceived_as_it_is_mounted_until_it_is_silent(desk):
    desk.until(lambda: desk.reads(5.0), lambda: desk.scan(2.0, 5.0))
    desk.until(lambda: desk.reads(math.nan))
    desk.until(lambda: desk.has_fault("sensor scan, /scan: silent, though it is published"))
    desk.until(lambda: not desk.has_fault("scan"), lambda: desk.scan(2.0))


@pytest.mark.parametrize("desk", [{"scan.patience": 10.0}], indirect=True)
def test_age_is_counted_from_the_stamp_and_patience_is_a_parameter(desk):
    desk.until(lambda: desk.reads(2.0), lambda: desk.scan(2.0, age=1.0))
    desk.until(lambda: desk.reads(math.nan), lambda: desk.scan(3.0, age=3600.0))
    old = "its readings are too old when they arrive; set the clocks"
    desk.until(lambda: desk.has_fault(old), lambda: desk.scan(3.0, age=3600.0))


@pytest.mark.parametrize("desk", [{"use_sim_time": True}], indirect=True)
def test_a_simulated_clock_that_comes_later_than_the_scans_is_no_fault(desk):
    clock = desk.robot.create_publisher(Clock, "/clock", 1)
    time = 10.0

    def simulate():
        nonlocal time
        time += 0.1
        desk.scan(2.0, stamp=int((time + 0.3) * 1e9))
        clock.publish(Clock(clock=as_time(int(time * 1e9))))

    desk.until(lambda: desk.reads(2.0) and time > 20.0, simulate)
    assert not desk.has_fault("ahead")


def test_a_robot_that_nothing_drives_is_told_to_stand_still_and_then_left_alone(desk):
    velocities = desk.hear_velocities()
    desk.action = (0.2, 0.1, -0.3)
    desk.until(lambda: velocities)
    twist = velocities[-1].twist
    assert (twist.linear.x, twist.linear.y, twist.angular.z) == (0.2, 0.1, -0.3)
    assert velocities[-1].header.stamp.sec > 0
    desk.action = ()
    desk.until(lambda: velocities[-1].twist.angular.z == 0.0)
    ticks = 0

    def is_quiet():
        nonlocal ticks
        if velocities:
            velocities.clear()
            ticks = len(desk.percepts)
        return len(desk.percepts) - ticks > 25

    desk.until(is_quiet)


def test_that_nothing_relays_is_a_fault(desk):
    desk.until(lambda: desk.has_fault("no velocity_relay listens on /robot_1/cmd_vel_agent"))
    desk.hear_velocities()
    desk.until(lambda: not desk.has_fault("relay"))


BASE = f"/robot_1/{BASE_TOPIC}"


@pytest.fixture
def driver(desk):
    """A process of the robot that HiTAB knows nothing of."""
    context = Context()
    rclpy.init(context=context, domain_id=desk.node.context.get_domain_id())
    yield rclpy.create_node("driver", namespace="/robot_1", context=context)
    context.try_shutdown()


def ignore(message):
    """Be subscribed."""


def test_a_robot_without_a_base_is_said_to_have_none(desk, driver):
    desk.start_relay()
    desk.until(lambda: desk.has_fault(f"no node subscribes to {BASE}"))
    driver.create_subscription(Twist, BASE_TOPIC, ignore, 10)
    desk.until(lambda: not desk.has_fault(BASE))


def test_a_base_that_does_not_take_what_the_relay_sends_is_named(desk, driver):
    base = driver.create_subscription(TwistStamped, BASE_TOPIC, ignore, 10)
    desk.start_relay()
    desk.until(lambda: desk.has_fault(f"{BASE} is sent as geometry_msgs/msg/Twist, but"))
    assert desk.has_fault("/robot_1/driver takes geometry_msgs/msg/TwistStamped;")
    assert desk.has_fault("set the parameter enable_stamped_cmd_vel to true")
    driver.destroy_subscription(base)
    driver.create_subscription(Twist, BASE_TOPIC, ignore, 10)
    desk.until(lambda: not desk.has_fault(BASE))


def test_a_base_that_wants_its_velocity_latched_is_named(desk, driver):
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    base = driver.create_subscription(Twist, BASE_TOPIC, ignore, latched)
    desk.start_relay()
    desk.until(lambda: desk.has_fault(f"/robot_1/driver gets nothing of {BASE}, since its QoS"))
    assert desk.has_fault("Volatile publisher and transient local subscription; have it subscribe")
    driver.destroy_subscription(base)
    driver.create_subscription(Twist, BASE_TOPIC, ignore, 10)
    desk.until(lambda: not desk.has_fault(BASE))


def test_a_robot_that_has_only_actions_misses_no_base(desk):
    desk.start_relay(max_velocity=[0.0, 0.0, 0.0])
    desk.until(lambda: desk.has_fault("sensor scan"))
    assert not desk.has_fault(BASE)


def test_the_base_is_told_to_stand_still_until_a_new_relay_gives_a_sign_of_life(monkeypatch):
    monkeypatch.setattr(relay_process, "MODULE", "no_such_relay")
    with context_of_its_own() as context:
        desk, told = Desk(context, relay=True), []
        desk.robot.create_subscription(Twist, BASE_TOPIC, told.append, 10)
        desk.until(lambda: len(told) > 3)
        assert all(velocity == Twist() for velocity in told)
        for node in (desk.node, desk.robot):
            desk.executor.remove_node(node)
            node.destroy_node()
        desk.executor.shutdown()


def test_who_drives_the_base_past_the_relay_is_named(desk, driver):
    desk.start_relay()
    driver.create_subscription(Twist, BASE_TOPIC, ignore, 10)
    publisher = driver.create_publisher(Twist, BASE_TOPIC, 10)
    desk.until(
        lambda: desk.has_fault(f"/robot_1/driver publishes {BASE}, past the velocity_relay")
    )
    assert desk.has_fault("remap it to /robot_1/cmd_vel_agent, as TwistStamped")
    driver.destroy_publisher(publisher)
    desk.until(lambda: not desk.has_fault(BASE))


@pytest.mark.parametrize("desk", [{"use_sim_time": True}], indirect=True)
def test_simulated_time_that_nobody_publishes_is_said_though_no_time_passes(desk, driver):
    desk.until(lambda: desk.has_fault("no node publishes /clock, so the agent never decides"))
    driver.create_publisher(Clock, "/clock", 1)
    desk.until(lambda: not desk.has_fault("/clock"))


def test_a_sensor_that_is_published_as_another_type_is_said_to_be(desk, driver):
    desk.robot.destroy_publisher(desk.scans)
    driver.create_publisher(PointStamped, "scan", 10)
    wrong = "published as geometry_msgs/msg/PointStamped and not as sensor_msgs/msg/LaserScan"
    desk.until(lambda: desk.has_fault(f"sensor scan, /robot_1/scan: {wrong}"))
