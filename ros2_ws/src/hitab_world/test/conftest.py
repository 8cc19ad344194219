"""A world's node, run by the test itself, and two agents that answer as the test says."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from hitab_msgs import msg, srv
from rclpy.task import Future

from hitab_ros import names, qos
from hitab_ros.nodes.guarded_node import GuardedNode
from hitab_ros.nodes.spinning import Spinner, spinner
from hitab_ros.ros_domains import reserved_domain
from hitab_world.node.world_node import WorldNode

AGENTS = ("a", "b")
SECONDS = 60.0


class Broken:
    """A world in which that fails which a test says."""

    name = "broken"
    agents = AGENTS
    cycle_seconds = 0.1
    size = (10.0, 10.0)
    ended = ""

    def __init__(self) -> None:
        self.seed = self.episode = self.cycle = self.episode_cycle = 0
        self.refused: dict[str, str] = {}
        self.looks: dict[str, Any] = {}
        self.broken: set[str] = set()
        self.acted: set[str] = set()

    def reset(self, episode: int | None = None, seed: int | None = None) -> None:
        self.seed = self.seed if seed is None else seed

    def percept(self, agent: str) -> tuple[list[float], list[str]]:
        if agent in self.broken:
            raise IndexError(f"no percept for {agent}")
        return [1.0], []

    def step(self, actions: Any) -> str | None:
        if "step" in self.broken:
            raise ZeroDivisionError("the physics")
        self.acted = set(actions)
        self.cycle += 1
        return None

    def snapshot(self) -> dict[str, int]:
        if "snapshot" in self.broken:
            raise KeyError("leaves")
        return {"cycle": self.cycle}

    def restore(self, snapshot: Any) -> None:
        self.cycle = snapshot["cycle"]

    def entities(self) -> list[Any]:
        if "entities" in self.broken:
            raise KeyError("entities")
        return []


class Running:
    """The node of a world, run by its own loop, and one that talks to it.

    Attributes:
        waiting: agents that wait for a dead commander in the first round after one in which they
            only look, as `RoundGate` has them do.
        slow: whether the agents need longer for their answers than anything else here takes.
        percepts: the percepts that an agent got.
        more: further fields of an agent's answers, such as ``hold``.
    """

    def __init__(self, spinning: Spinner) -> None:
        self.slow = False
        self.waiting: set[str] = set()
        self.looked: set[str] = set()
        self.percepts: dict[str, list[msg.Percept]] = {agent: [] for agent in AGENTS}
        self.more: dict[str, dict[str, Any]] = {}
        self.world = Broken()
        self.spinning = spinning
        self.node = WorldNode(lambda node, seed: self.world)
        self.node.control.pace = "lockstep"
        self.peer = GuardedNode("peer")
        self.status = msg.WorldStatus()
        spinning.executor.add_node(self.node)
        spinning.executor.add_node(self.peer)
        self.node.join()
        self.answers = {
            agent: self.peer.create_publisher(msg.Action, f"/{names.ACTIONS}", qos.CYCLE)
            for agent in AGENTS
        }
        for agent in AGENTS:
            self.peer.create_subscription(
                msg.Percept,
                f"/{agent}/{names.PERCEPT}",
                lambda percept, agent=agent: self._answer(agent, percept),
                qos.CYCLE,
            )
        self.peer.create_subscription(msg.WorldStatus, f"/{names.STATUS}", self._hear, qos.LATCHED)
        # One timer for all waits: that of an earlier wait may still be called once destroyed.
        self.look: Callable[[], None] = lambda: None
        self.peer.create_timer(0.01, lambda: self.look())

    def _answer(self, agent: str, percept: msg.Percept) -> None:
        self.percepts[agent].append(percept)
        if self.slow:
            return
        if percept.look:
            self.looked |= self.waiting
        elif agent in self.looked:
            self.looked.discard(agent)
            return
        more = self.more.get(agent, {})
        action = msg.Action(agent=agent, sequence=percept.sequence, values=[1.0], **more)
        self.answers[agent].publish(action)

    def _hear(self, status: msg.WorldStatus) -> None:
        self.status = status

    def until(self, condition: Callable[[], Any]) -> None:
        """Run the world until a condition holds."""
        clock = self.peer.get_clock()
        end = clock.now().nanoseconds + int(SECONDS * 1e9)
        held = False

        def look() -> None:
            nonlocal held
            held = bool(condition())
            if held or clock.now().nanoseconds > end:
                self.spinning.stop()

        self.look = look
        self.spinning.stopped = False
        self.node.run(self.spinning)
        assert held, f"it did not happen in time: {self.status}"

    def plays(self) -> None:
        """Wait until ten more cycles have been played with all agents."""
        begun = self.world.cycle
        self.until(lambda: self.world.cycle > begun + 10 and self.world.acted == {*AGENTS})

    def call(self, kind: Any, name: str, request: Any) -> Future:
        """Call a service of the world."""
        client = self.peer.create_client(kind, f"/{name}")
        self.until(client.service_is_ready)
        return client.call_async(request)

    def control(self, action: str, **fields: Any) -> srv.Control.Response:
        """Control the world and return its answer."""
        request = srv.Control.Request(action=action, **fields)
        answer = self.call(srv.Control, names.CONTROL, request)
        self.until(answer.done)
        return answer.result()


@contextlib.contextmanager
def _running_world(*arguments: str) -> Iterator[Running]:
    with pytest.MonkeyPatch.context() as patch, reserved_domain() as number:
        patch.setenv("ROS_DOMAIN_ID", str(number))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        assert os.environ["ROS_DOMAIN_ID"]
        with spinner(arguments) as spinning:
            yield Running(spinning)


@pytest.fixture
def running_world() -> Callable[..., contextlib.AbstractContextManager[Running]]:
    """Return what runs a world, with arguments for its process."""
    return _running_world


@pytest.fixture
def running() -> Iterator[Running]:
    with _running_world() as running:
        yield running
