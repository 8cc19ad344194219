"""A team for the tests: commanders and agents, real nodes over real topics, in one process."""

import contextlib
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from builtin_interfaces.msg import Time
from hitab_msgs import msg, srv
from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from rclpy.parameter import Parameter

from hitab_agent.host_resources import HostResources
from hitab_agent.node.agent_node import AgentNode
from hitab_commander.commander_node import CommanderNode
from hitab_core.domain import BasicBehavior, Domain, Feature, FeatureKind
from hitab_core.operations import BeginTraining, Command, Perform
from hitab_core.training.operation import Operation
from hitab_ros import GuardedNode, Lease, give_signs_of_life, names, qos
from hitab_ros.leases import NO_LEASE
from hitab_ros.messages.conversions import request_of
from hitab_ros.testing import context_of_its_own

SECONDS = 60.0


class Ant:
    """A body that tells which behaviors were begun; it perceives x, y and whether it is home."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.values: tuple[float, ...] = ()
        self.begun: list[str] = []

    @property
    def position(self) -> tuple[float, float]:
        return self.values[0], self.values[1]

    def sense(self, values: Any, heard: Any) -> None:
        self.values = tuple(values)

    def act(self) -> tuple[tuple[float, ...], str]:
        return (1.0,), ""


def _behavior(name: str) -> BasicBehavior:
    return BasicBehavior(name, start=lambda body: body.begun.append(name))


ANT = Domain.of(
    "ant",
    "1",
    Ant,
    behaviors=[_behavior(name) for name in ("Search", "Follow", "Home", "Wait")],
    features=[
        Feature("X", lambda body: body.values[0]),
        Feature("AtHome", lambda body: body.values[2], FeatureKind.BOOLEAN),
    ],
)


class Host:
    """A host of the team: its desk, and what its nodes share.

    Attributes:
        batches: what other hosts sent to it, or this one sent to itself.
        yielded: why it yields; the test has to end it.
    """

    def __init__(self, team: "Team", name: str, lease: Lease) -> None:
        self.name = name
        self.desk = GuardedNode("host", namespace=f"/{name}", context=team.context)
        team.executor.add_node(self.desk)
        self.yielded: list[str] = []
        self.shared = HostResources(
            self.desk,
            is_host=True,
            on_demand=True,
            swarm="team",
            lease=lease,
            give_up=self.yielded.append,
        )
        self.batches: list[msg.Orders | msg.Reports] = []
        for kind, topic in ((msg.Orders, names.ORDERS), (msg.Reports, names.REPORTS)):
            team.link.create_subscription(
                kind, f"/{name}/{topic}", self.batches.append, qos.EVENTS
            )
        self._percepts = team.link.create_publisher(
            msg.PerceptBatch, f"/{name}/{names.PERCEPTS}", qos.CYCLE
        )
        self._team, self._cycle = team, 0

    def publish_roster(self) -> None:
        """Begin to live, as a host does once all of its nodes have joined."""
        for link in self.shared.links.values():
            link.listen()
        self.shared.roster.publish()
        if self._team.gives_signs:
            give_signs_of_life(self.desk, "team", self.shared.signs.fill)

    def play(self, agents: int) -> int:
        """Give the first of its nodes a percept each, and return the cycle."""
        self._team.until(self._percepts.get_subscription_count)
        self._cycle += 1
        batch = msg.PerceptBatch(agents=range(agents), value_counts=[3] * agents)
        batch.roster, batch.values = self.shared.roster.number, [0.0] * 3 * agents
        batch.sequence = batch.cycle = self._cycle
        self._percepts.publish(batch)
        nodes = self.shared.nodes[:agents]
        self._team.until(lambda: all(node.agent.cycle == self._cycle for node in nodes))
        return self._cycle


class AntNode(AgentNode):
    """The node of an ant."""

    def load_domain(self, name: str) -> Domain:
        return ANT


class Team:
    """Nodes of a swarm, and what is needed to talk to them.

    Attributes:
        orders: all that were published, by commander.
        gives_signs: whether nodes that are created give signs of life, as their processes do.
    """

    def __init__(self, folder: Path, context: Context) -> None:
        self.gives_signs = True
        self.folder = folder
        self.context = context
        self.executor = EventsExecutor(context=context)
        self.nodes: dict[str, Any] = {}
        self.hosts: dict[str, Host] = {}
        self.link = rclpy.create_node(
            "test", context=context, enable_rosout=False, start_parameter_services=False
        )
        self.executor.add_node(self.link)
        self.statuses: dict[str, msg.AgentStatus] = defaultdict(msg.AgentStatus)
        self.groups: dict[str, msg.CommanderStatus] = defaultdict(msg.CommanderStatus)
        self.orders: dict[str, list[msg.Order]] = {}
        self._percepts: dict[str, Any] = {}
        self._cycle = 0

    # -- nodes ------------------------------------------------------------------------------

    def obeying(self) -> list[bool]:
        """Return which subordinates of the chief perform its order."""
        return [member.obeys for member in self.groups["chief"].subordinates]

    def host(self, name: str, lease: Lease = NO_LEASE) -> Host:
        """Start a host, without nodes so far."""
        self.hosts[name] = Host(self, name, lease)
        return self.hosts[name]

    def end_host(self, name: str) -> None:
        """End a host with its nodes."""
        host = self.hosts.pop(name)
        for node in host.shared.nodes:
            self.end(node.agent_name)
        self.executor.remove_node(host.desk)
        host.desk.destroy_node()

    def ant(self, name: str, commander: str = "", role: str = "", **settings: Any) -> AntNode:
        return self._join(AntNode, name, commander=commander, role=role, **settings)

    def commander(
        self,
        name: str,
        kind: str,
        subordinates: list[str],
        superior: str = "",
        *,
        orders_are_shown: bool = True,
        **settings: Any,
    ) -> CommanderNode:
        file = self.folder / f"{name}.yaml"
        file.write_text(kind)
        if name not in self.orders:
            self.orders[name] = []
            if orders_are_shown:
                self._listen(msg.Order, name, names.ORDER, self.orders[name].append)
            self._listen(
                msg.CommanderStatus, name, names.GROUP, lambda g: self.groups.__setitem__(name, g)
            )
        return self._join(
            CommanderNode,
            name,
            domain=str(file),
            subordinates=subordinates,
            commander=superior,
            **settings,
        )

    def _join(
        self,
        node_class: Any,
        name: str,
        *,
        host: Host | None = None,
        is_watched: bool = True,
        **settings: Any,
    ) -> Any:
        settings = {
            "swarm": "team",
            "state_dir": str(self.folder / "state"),
            "library": str(self.folder / "libraries" / name),
            **settings,
        }
        node = node_class(
            namespace=f"/{name}",
            context=self.context,
            parameter_overrides=[Parameter(k, value=v) for k, v in settings.items()],
            use_global_arguments=False,
            shared=host and host.shared,
        )
        if is_watched and name not in self._percepts:
            self._percepts[name] = None
            self._listen(
                msg.AgentStatus, name, names.STATUS, lambda s: self.statuses.__setitem__(name, s)
            )
        self.executor.add_node(node)
        self.nodes[name] = node
        node.join()
        if self.gives_signs and host is None:
            give_signs_of_life(node, fill=node.shared.signs.fill)
        return node

    def _listen(self, kind: Any, name: str, topic: str, take: Callable[[Any], None]) -> None:
        self.link.create_subscription(kind, f"/{name}/{topic}", take, qos.LATCHED)

    def end(self, name: str) -> None:
        """End a node, as the end of its process does."""
        node = self.nodes.pop(name)
        self.executor.remove_node(node)
        node.destroy_node()
        node.agent.journal.close()  # as the end of a process does

    def close(self) -> None:
        for name in list(self.hosts):
            self.end_host(name)
        for name in list(self.nodes):
            self.end(name)
        self.executor.remove_node(self.link)
        self.link.destroy_node()
        self.executor.shutdown()

    # -- time -------------------------------------------------------------------------------

    def until(self, condition: Callable[[], Any], seconds: float = SECONDS) -> None:
        assert self.holds(condition, seconds), "it did not happen in time"

    def holds(self, condition: Callable[[], Any], seconds: float) -> bool:
        """Handle events until a condition holds; return whether it did in time."""
        clock = self.link.get_clock()
        deadline = clock.now().nanoseconds + int(seconds * 1e9)
        while not condition():
            if clock.now().nanoseconds > deadline:
                return False
            self.executor.spin_once(timeout_sec=0.02)
        return True

    # -- talking ----------------------------------------------------------------------------

    def perceive(self, name: str, *values: float, episode: int = 0) -> None:
        """Give an ant a percept."""
        if self._percepts[name] is None:
            self._percepts[name] = self.link.create_publisher(
                msg.Percept, f"/{name}/{names.PERCEPT}", qos.CYCLE
            )
        publisher = self._percepts[name]
        self.until(lambda: publisher.get_subscription_count() > 0)
        self._cycle += 1
        publisher.publish(
            msg.Percept(
                stamp=Time(sec=self._cycle),
                sequence=self._cycle,
                cycle=self._cycle,
                values=list(values),
                episode=episode,
                restart=episode > 0,
            )
        )
        self.until(lambda: self.nodes[name].agent.cycle >= self._cycle)

    def command(self, name: str, behavior: str) -> Any:
        return self.do(name, Command(behavior, by="me"))

    def perform(self, name: str, behavior: str) -> Any:
        return self.do(name, Perform(behavior))

    def train(self, name: str, automaton: str, *features: str) -> Any:
        return self.do(name, BeginTraining(automaton, features))

    def do(self, name: str, operation: Operation) -> Any:
        """Have an agent carry out an operation, and return the answer of its service."""
        kind = getattr(srv, type(operation).__name__)
        return self._call(kind, f"/{name}/{operation.name}", request_of(operation))

    def ask(self, kind: Any, name: str, service: str, **fields: Any) -> Any:
        return self._call(kind, f"/{name}/{service}", kind.Request(**fields))

    def _call(self, kind: Any, service: str, request: Any) -> Any:
        client = self.link.create_client(kind, service)
        self.until(client.service_is_ready)
        future = client.call_async(request)
        self.until(future.done)
        self.link.destroy_client(client)
        return future.result()

    def sees(self, name: str, feature: str) -> float:
        """Return the value of a feature as an agent or commander perceives it now."""
        answer = self.ask(srv.ReadFeatures, name, "read_features", also=[feature])
        return next(r.value for r in answer.readings if r.feature == feature)

    def begun(self, name: str) -> list[str]:
        return self.nodes[name].agent.body.begun

    def performs(self, name: str) -> str:
        return self.nodes[name].agent.behavior


@pytest.fixture
def team(tmp_path: Path) -> Iterator[Team]:
    """An empty team, in a ROS domain of its own."""
    with context_of_its_own() as context, contextlib.closing(Team(tmp_path, context)) as made:
        yield made
