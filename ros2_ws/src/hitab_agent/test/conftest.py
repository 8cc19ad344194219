"""A process for the tests: real nodes over real topics, handled by the test itself."""

import contextlib
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from hitab_msgs import msg, srv
from rclpy.clock import Clock, ClockType
from rclpy.experimental import EventsExecutor
from rclpy.parameter import Parameter

from hitab_agent.node.agent_node import AgentNode
from hitab_core import Domain
from hitab_core.operations import Command
from hitab_core.training.operation import Operation
from hitab_ros import names, qos
from hitab_ros.messages.conversions import request_of
from hitab_ros.nodes.guarded_node import GuardedNode
from hitab_ros.nodes.spinning import Spinner
from hitab_ros.testing import context_of_its_own, spin_until


class Process:
    """A node, and others where a test adds them, in a ROS domain of its own."""

    def __init__(self, node: GuardedNode, executor: EventsExecutor) -> None:
        self.node = node
        self._executor = executor
        self._nodes: list[GuardedNode] = []
        self.add(node)

    def add(self, node: GuardedNode) -> None:
        """Have another node in it; it is taken down at the end."""
        self._executor.add_node(node)
        self._nodes.append(node)

    def close(self) -> None:
        """End, as a process of the project does."""
        while self._nodes:
            node = self._nodes.pop()
            self._executor.remove_node(node)
            node.destroy_node()
        self._executor.shutdown()

    def spinner(self) -> Spinner:
        return Spinner(self._executor)

    def until(self, condition: Callable[[], Any]) -> None:
        spin_until(self._executor, condition)

    def meanwhile(self, done: list[Any], seconds: float = 0.005) -> None:
        """Do something else, again and again."""
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.node.create_timer(seconds, lambda: done.append("something else"), clock=clock)


@pytest.fixture
def process() -> Iterator[Process]:
    with context_of_its_own() as context:
        node = GuardedNode("host", context=context)
        executor = EventsExecutor(context=context)
        with contextlib.closing(Process(node, executor)) as made:
            yield made


class One:
    """One agent in the process of the test, and what is needed to talk to it.

    Attributes:
        status: the agent's last published status.
    """

    def __init__(
        self,
        process: Process,
        folder: Path,
        domain: Domain,
        name: str = "one",
        shared: Any = None,
        watched: bool = True,
        **parameters: Any,
    ) -> None:
        class OneNode(AgentNode):
            def load_domain(self, name: str) -> Domain:
                return domain

        given = {"state_dir": str(folder), **parameters}
        self.process, self.name, self.folder = process, name, folder
        self.node = OneNode(
            namespace=f"/{name}",
            context=process.node.context,
            parameter_overrides=[Parameter(key, value=value) for key, value in given.items()],
            use_global_arguments=False,
            shared=shared,
        )
        process.add(self.node)
        self.agent, self.body = self.node.agent, self.node.agent.body
        self.status = msg.AgentStatus()
        desk, self._cycle = process.node, 0
        if not watched:
            self.node.join()
            return
        desk.create_subscription(msg.AgentStatus, self._of(names.STATUS), self._hear, qos.LATCHED)
        self._percepts = desk.create_publisher(msg.Percept, self._of(names.PERCEPT), qos.CYCLE)
        self.node.join()
        process.until(lambda: self.status.agent)

    def _of(self, name: str) -> str:
        return f"/{self.name}/{name}"

    def _hear(self, status: msg.AgentStatus) -> None:
        if status.sequence >= self.status.sequence:
            self.status = status

    @property
    def faults(self) -> str:
        return "; ".join(self.node.status.faults)

    def perceive(self, x: float = 1.0, **fields: Any) -> list[str]:
        """Have it perceive and act once; return its active states."""
        self.process.until(self._percepts.get_subscription_count)
        self._cycle += 1
        percept = msg.Percept(cycle=self._cycle, sequence=self._cycle, values=[x], **fields)
        self._percepts.publish(percept)
        self.process.until(lambda: self.agent.cycle == self._cycle)
        return self.agent.active_path

    def command(self, behavior: str, by: str = "me") -> Any:
        return self.do(Command(behavior, by=by))

    def do(self, operation: Operation) -> Any:
        """Have it carry an operation out, and return the answer of its service."""
        kind = getattr(srv, type(operation).__name__)
        return self._call(kind, operation.name, request_of(operation))

    def ask(self, kind: Any, service: str, **fields: Any) -> Any:
        return self._call(kind, service, kind.Request(**fields))

    def _call(self, kind: Any, service: str, request: Any) -> Any:
        client = self.process.node.create_client(kind, self._of(service))
        self.process.until(client.service_is_ready)
        future = client.call_async(request)
        self.process.until(future.done)
        answer = future.result()
        self._hear(getattr(answer, "status", self.status))
        return answer


@pytest.fixture
def start(process: Process, tmp_path: Path) -> Callable[..., One]:
    """Return what starts an agent of a domain."""
    return partial(One, process, tmp_path)
