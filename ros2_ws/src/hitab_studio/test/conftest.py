"""Stand-ins for swarms in the studio's tests: a world with agents, and a robot with its agent."""

import array
import contextlib
import io
import math
import threading
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import Quaternion
from hitab_msgs import msg, srv
from nav_msgs.msg import OccupancyGrid, Odometry
from PIL import Image
from rclpy.experimental import EventsExecutor
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CompressedImage, LaserScan

from hitab_ros import qos
from hitab_ros.testing import context_of_its_own
from hitab_studio.swarm.swarm_finder import SwarmTarget

FEATURES = 400


class StandIn:
    """A stand-in for a world and two agents, in a separate thread.

    Attributes:
        target: the target to be found by the studio.
        nonsense: whether keeper_2 gives invalid answers.
        alive: processes that give signs of life.
        node: the node with which it publishes.
    """

    def __init__(self, context: Any) -> None:
        self.target = SwarmTarget(context.get_domain_id(), "stand_in", ("keeper_1", "keeper_2"), 1)
        self.nonsense = False
        self.alive: tuple[str, ...] = ()
        self._cycle = self._reading = 0
        self._context = context
        self._ending = threading.Event()
        self.node = rclpy.create_node("stand_in", context=context, enable_rosout=False)
        self._state = self.node.create_publisher(msg.WorldState, "/world/state", qos.LATCHED)
        self._signs = self.node.create_publisher(msg.Alive, "/alive", qos.SIGNS_OF_LIFE)
        self.node.create_timer(0.02, self._show)
        self._statuses = {}
        for agent in self.target.agents:
            status = self.node.create_publisher(msg.AgentStatus, f"/{agent}/status", qos.LATCHED)
            status.publish(msg.AgentStatus(agent=agent, mode="idle", domain="stand_in"))
            self._statuses[agent] = status
            self.node.create_service(
                srv.GetVocabulary,
                f"/{agent}/get_vocabulary",
                lambda _, answer, agent=agent: self._vocabulary(agent, answer),
            )
            self.node.create_service(
                srv.ReadFeatures, f"/{agent}/read_features", self._read_features
            )
        self._thread = threading.Thread(target=self._spin)
        self._thread.start()

    def _show(self) -> None:
        self._cycle += 1
        for name in self.alive:
            self._signs.publish(msg.Alive(process=name))
        ball = msg.Entity(name="ball", kind="ball", x=0.001 * self._cycle)
        self._state.publish(
            msg.WorldState(cycle=self._cycle, width=20.0, height=20.0, entities=[ball])
        )

    def belong_to(self, identity: str) -> None:
        """Publish this identity of the swarm from now on."""
        self._world = self.node.create_publisher(msg.WorldStatus, "/world/status", qos.LATCHED)
        self._world.publish(msg.WorldStatus(world="stand_in", swarm=identity))
        for agent, publisher in self._statuses.items():
            publisher.publish(
                msg.AgentStatus(agent=agent, mode="idle", domain="stand_in", swarm=identity)
            )

    def _vocabulary(self, agent: str, answer: Any) -> Any:
        answer.domain = "stand_in"
        name = "Angle(" if self.nonsense and agent == "keeper_2" else "Angle"
        answer.features = [msg.Feature(name="Range", unit="m"), msg.Feature(name=name, unit="rad")]
        return answer

    def _read_features(self, _: Any, answer: Any) -> Any:
        """Answer with many features of the same value, which changes with each answer."""
        self._reading += 1
        answer.success = True
        answer.readings = [
            msg.Reading(automaton="Go", feature=f"Feature{i}", value=float(self._reading))
            for i in range(FEATURES)
        ]
        return answer

    def _spin(self) -> None:
        executor = EventsExecutor(context=self._context)
        executor.add_node(self.node)
        while not self._ending.is_set():
            executor.spin_once(timeout_sec=0.02)
        executor.remove_node(self.node)
        self.node.destroy_node()
        executor.shutdown()

    def close(self) -> None:
        self._ending.set()
        self._thread.join()


@pytest.fixture
def stand_in(monkeypatch, tmp_path) -> Iterator[StandIn]:
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    with context_of_its_own() as context, contextlib.closing(StandIn(context)) as made:
        yield made


ROBOT = "robot_1"
PERIOD = 0.05


def turned(yaw: float) -> Quaternion:
    return Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2))


class RobotStandIn:
    """A stand-in for a robot and its agent, in a separate thread, with changeable messages.

    Attributes:
        target: the target to be found by the studio.
        odometry, scan, map, picture: the published messages; None to publish nothing.
    """

    def __init__(self, context: Any, robot: str = ROBOT, yaw: float = 0.0) -> None:
        self.target = SwarmTarget(context.get_domain_id(), "robots", (robot,), 1)
        self.odometry: Odometry | None = None
        self.scan: LaserScan | None = None
        self.stand(0.0, 0.0, 0.0)
        self.see()
        self.map: OccupancyGrid | None = None
        self.picture: CompressedImage | None = None
        self._context = context
        self._ending, self._agent_ends = threading.Event(), threading.Event()
        self._agent = rclpy.create_node(
            "agent",
            namespace=f"/{robot}",
            context=context,
            automatically_declare_parameters_from_overrides=True,
            parameter_overrides=[
                *(rclpy.Parameter(f"scan.{name}", value=0.0) for name in ("x", "y")),
                rclpy.Parameter("scan.yaw", value=yaw),
                rclpy.Parameter("scan.upside_down", value=False),
            ],
        )
        self._status = self._agent.create_publisher(msg.AgentStatus, "status", qos.LATCHED)
        self._status.publish(msg.AgentStatus(agent=robot, mode="idle", domain="stand_in"))
        for kind, topic in ((msg.Command, "command"), (Odometry, "odom"), (LaserScan, "scan")):
            self._agent.create_subscription(kind, topic, lambda _: None, qos_profile_sensor_data)
        self._agent.create_service(srv.GetVocabulary, "get_vocabulary", self._vocabulary)
        self._node = rclpy.create_node("robot", namespace=f"/{robot}", context=context)
        create = self._node.create_publisher
        self._publishers = {
            "odometry": create(Odometry, "odom", 10),
            "scan": create(LaserScan, "scan", qos_profile_sensor_data),
            "map": create(OccupancyGrid, "/map", qos.LATCHED),
            "picture": create(CompressedImage, "camera/image_raw/compressed", 1),
        }
        self._shown: Any = None
        self._node.create_timer(PERIOD, self._publish)
        self._thread = threading.Thread(target=self._spin)
        self._thread.start()

    @staticmethod
    def _vocabulary(_: Any, answer: Any) -> Any:
        answer.domain = "stand_in"
        return answer

    def listeners(self, what: str) -> int:
        """Return the number of subscribers of a topic."""
        return int(self._publishers[what].get_subscription_count())

    def stand(self, x: float, y: float, yaw: float) -> None:
        """Publish odometry at this pose."""
        odometry = Odometry(child_frame_id="base_link")
        odometry.header.frame_id = "odom"
        odometry.pose.pose.position.x, odometry.pose.pose.position.y = x, y
        odometry.pose.pose.orientation = turned(yaw)
        self.odometry = odometry

    def see(self, *ranges: float) -> None:
        """Publish a scan with these ranges behind, right, ahead and left of the scanner, m."""
        scan = LaserScan(
            angle_min=-math.pi, angle_increment=math.pi / 2, range_min=0.1, range_max=5.0
        )
        scan.header.frame_id = "laser"
        scan.ranges = list(ranges)
        self.scan = scan

    def film(self, data: bytes, claimed: str = "png") -> None:
        """Publish a camera picture."""
        self.picture = CompressedImage(format=claimed, data=array.array("B", data))

    def draw_map(self, cells: Any, resolution: float, x: float, y: float, yaw: float) -> None:
        """Publish a map with cells of shape (height, width)."""
        grid = OccupancyGrid(data=array.array("b", np.asarray(cells, np.int8).tobytes()))
        grid.header.frame_id = "map"
        grid.info.height, grid.info.width = np.shape(cells)
        grid.info.resolution = resolution
        grid.info.origin.position.x, grid.info.origin.position.y = x, y
        grid.info.origin.orientation = turned(yaw)
        self.map = grid

    @staticmethod
    def png(width: int, height: int) -> bytes:
        """Return a PNG of this size."""
        out = io.BytesIO()
        Image.new("RGB", (width, height), "red").save(out, "PNG")
        return out.getvalue()

    def _publish(self) -> None:
        now = self._node.get_clock().now().to_msg()
        for name, publisher in self._publishers.items():
            message = getattr(self, name)
            if message is None or (name == "map" and message is self._shown):
                continue
            if name == "map":
                self._shown = message
            message.header.stamp = now
            publisher.publish(message)

    def _spin(self) -> None:
        executor = EventsExecutor(context=self._context)
        nodes = {self._agent: self._agent_ends, self._node: self._ending}
        for node in nodes:
            executor.add_node(node)
        while nodes:
            executor.spin_once(timeout_sec=0.02)
            for node in [node for node, ends in nodes.items() if ends.is_set()]:
                del nodes[node]
                executor.remove_node(node)
                node.destroy_node()
        executor.shutdown()

    def end_agent(self) -> None:
        """End the agent, but not the robot."""
        self._agent_ends.set()

    def close(self) -> None:
        self._agent_ends.set()
        self._ending.set()
        self._thread.join()


@pytest.fixture
def robot(monkeypatch, tmp_path) -> Iterator[RobotStandIn]:
    """Return a robot whose scanner faces left."""
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    with (
        context_of_its_own() as context,
        contextlib.closing(RobotStandIn(context, yaw=math.pi / 2)) as made,
    ):
        yield made
