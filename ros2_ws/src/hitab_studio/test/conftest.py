"""A swarm for the studio's tests: one real node that plays a world and its agents."""

import contextlib
import threading
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from hitab_msgs import msg, srv
from rclpy.experimental import EventsExecutor

from hitab_ros import qos
from hitab_ros.testing import context_of_its_own
from hitab_studio.finding import Target

FEATURES = 400


class StandIn:
    """A world that shows itself and two agents that answer, in a thread of their own.

    Attributes:
        target: what the studio is to find.
        nonsense: whether keeper_2 answers what nobody can read.
    """

    def __init__(self, context: Any) -> None:
        self.target = Target(context.get_domain_id(), "stand_in", ("keeper_1", "keeper_2"), 1)
        self.nonsense = False
        self._cycle = self._reading = 0
        self._context = context
        self._ending = threading.Event()
        self._node = rclpy.create_node("stand_in", context=context, enable_rosout=False)
        self._state = self._node.create_publisher(msg.WorldState, "/world/state", qos.LATCHED)
        self._node.create_timer(0.02, self._show)
        self._statuses = []
        for agent in self.target.agents:
            status = self._node.create_publisher(msg.AgentStatus, f"/{agent}/status", qos.LATCHED)
            status.publish(msg.AgentStatus(agent=agent, mode="idle", domain="stand_in"))
            self._statuses.append(status)
            self._node.create_service(
                srv.GetVocabulary,
                f"/{agent}/get_vocabulary",
                lambda _, answer, agent=agent: self._vocabulary(agent, answer),
            )
            self._node.create_service(
                srv.ReadFeatures, f"/{agent}/read_features", self._read_features
            )
        self._thread = threading.Thread(target=self._spin)
        self._thread.start()

    def _show(self) -> None:
        self._cycle += 1
        ball = msg.Entity(name="ball", kind="ball", x=0.001 * self._cycle)
        self._state.publish(
            msg.WorldState(cycle=self._cycle, width=20.0, height=20.0, entities=[ball])
        )

    def _vocabulary(self, agent: str, answer: Any) -> Any:
        answer.domain = "stand_in"
        answer.features = ["Range", "Angle"]
        wrong = self.nonsense and agent == "keeper_2"
        answer.feature_units = ["m"] if wrong else ["m", "rad"]
        return answer

    def _read_features(self, _: Any, answer: Any) -> Any:
        """Answer with many features that all have the same value, another one each time."""
        self._reading += 1
        answer.success = True
        answer.automata = ["Go"] * FEATURES
        answer.features = [f"Feature{i}" for i in range(FEATURES)]
        answer.values = [float(self._reading)] * FEATURES
        return answer

    def _spin(self) -> None:
        executor = EventsExecutor(context=self._context)
        executor.add_node(self._node)
        while not self._ending.is_set():
            executor.spin_once(timeout_sec=0.02)
        executor.remove_node(self._node)
        self._node.destroy_node()
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
