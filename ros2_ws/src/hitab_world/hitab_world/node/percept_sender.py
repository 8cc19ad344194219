"""The sender of a world's percepts: to agents with their own topics, and to hosts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hitab_msgs import msg

from hitab_ros import GuardedNode, names, qos
from hitab_ros.messages.cycle_codec import percept_bytes, read_action
from hitab_world.node.host_registry import ANY_SWARM, HostRegistry, PerceptOf, SwarmSettings
from hitab_world.simulating.lockstep import Take

EARLY_TOPICS_MAX = 64  # number of agents up to which topics are created before agents join


class PerceptSender:
    """Sends percepts, one message per agent or host, and passes on the answers."""

    def __init__(self, node: GuardedNode, agents: tuple[str, ...], *, hosts: int = 0) -> None:
        """Create the topics of agents that are expected as processes of their own.

        Args:
            node: the world's node.
            agents: all agents of the world.
            hosts: number of hosts that are expected to run the agents.
        """
        self._node = node
        self._agents = agents
        self._unexpected = set(agents)
        self._publishers: dict[str, Any] = {}
        self._counts: dict[str, int] = {}
        self._answering: frozenset[bytes] = frozenset()
        self._hosts: HostRegistry | None = None
        if not hosts and len(agents) <= EARLY_TOPICS_MAX:
            for name in agents:
                self._expect(name)

    def join(
        self,
        take: Take,
        swarm: SwarmSettings = ANY_SWARM,
        report: Callable[[str], None] = lambda text: None,
    ) -> None:
        """Receive answers; pass each to ``take`` with the sequence of its percept.

        Args:
            take, swarm, report: see `HostRegistry`.
        """

        def on_action(action: msg.Action) -> None:
            take(
                action.agent,
                action.sequence,
                (action.values, action.say),
                taught=action.taught,
                hold=action.hold,
            )

        # All agents may answer before this process reads the first answer.
        self._node.create_subscription(
            msg.Action, names.ACTIONS, on_action, qos.ROLL_CALL, read=read_action
        )
        self._hosts = HostRegistry(self._node, self._agents, take, swarm, report)

    def look(self) -> bool:
        """Update who is present; return whether a receiver of percepts was newly discovered.

        However many agents there are, the ROS graph is asked once, for those that publish actions:
        hosts announce themselves. Discovery may find the successor of a killed process before it
        drops the killed one, or at the same time, so numbers of receivers do not show all changes.
        """
        actions = self._node.resolve_topic_name(names.ACTIONS)
        ends = self._node.get_publishers_info_by_topic(actions)
        prefix = names.in_swarm(self._node, "")
        answering_names = {end.node_namespace.removeprefix(prefix) for end in ends}
        for name in self._unexpected & answering_names:
            self._expect(name)  # the agent is present once discovery has matched it
        before, answering = self._counts, self._answering
        self._answering = frozenset(bytes(end.endpoint_gid) for end in ends)
        self._counts = {
            name: publisher.get_subscription_count()
            for name, publisher in self._publishers.items()
        }
        new = any(count > before.get(name, 0) for name, count in self._counts.items())
        alone = {name for name in answering_names if self._counts.get(name)}
        hosts_changed = self._hosts is not None and self._hosts.look(alone)
        return hosts_changed or new or not self._answering <= answering

    @property
    def hosts(self) -> int:
        """How many hosts were present at the last `look`."""
        return 0 if self._hosts is None else self._hosts.present

    def has(self, agent: str) -> bool:
        """Return whether a node or a host answers for an agent."""
        if self._hosted(agent):
            return True
        publisher = self._publishers.get(agent)
        return publisher is not None and bool(publisher.get_subscription_count())

    def send(self, common: dict[str, Any], percept_of: PerceptOf) -> None:
        """Send the percepts to all agents and hosts.

        Args:
            common: the fields that all percepts of a cycle share.
            percept_of: returns an agent's percept; None to send nothing.
        """
        for name, publisher in self._publishers.items():
            if self._hosted(name) or not publisher.get_subscription_count():
                continue
            if (sensed := percept_of(name)) is not None:
                publisher.publish(percept_bytes(**common, values=sensed[0], heard=sensed[1]))
        if self._hosts is not None:
            self._hosts.send(common, percept_of)

    def _hosted(self, agent: str) -> bool:
        return self._hosts is not None and self._hosts.has(agent)

    def _expect(self, agent: str) -> None:
        topic = names.in_swarm(self._node, agent, names.PERCEPT)
        self._publishers[agent] = self._node.create_publisher(msg.Percept, topic, qos.CYCLE)
        self._unexpected.discard(agent)
