"""Players with commanders, for the loop that plays a world in one process.

The loop is `hitab_world.inprocess.play`. Agents and commanders are those of `hitab_core` and of
this package. All decisions are the same, bit for bit, as over topics in lockstep
(`hitab_commander.rounds`); reports and orders are passed as objects.

Example::

    world = ForagingWorld(seed=7)
    hierarchy = HierarchyPlayers(
        [Member(name, library) for name in world.agents],
        [Commander("squad_1", kind, squad_library, "SquadForage", world.agents[:5])],
    )
    results = play(world, hierarchy.players, episodes=30, between=hierarchy.confer)
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

from hitab_commander.commander_body import CommanderBody
from hitab_commander.commander_domain import commander_domain
from hitab_commander.kinds.kind import CommanderKind
from hitab_commander.rounds import Lockstep, Round
from hitab_core import Agent, BehaviorLibrary, FeatureValueError, Term
from hitab_core.orders import Report, Subordinate


@dataclass(frozen=True)
class Member:
    """An agent of a hierarchy.

    Attributes:
        behavior: the behavior until the first order; empty if none.
    """

    name: str
    library: BehaviorLibrary
    behavior: str = ""


@dataclass(frozen=True)
class Commander:
    """A commander of a hierarchy.

    Attributes:
        library: behaviors for the domain of its kind; see `commander_domain`.
        behavior: the behavior until the first order; empty if none.
        subordinates: names of agents, or of commanders that are listed before this one.
        roles: roles of the subordinates that have one, by name.
        asks_position: whether a superior needs the subordinates' positions.
    """

    name: str
    kind: CommanderKind
    library: BehaviorLibrary
    behavior: str
    subordinates: tuple[str, ...]
    roles: Mapping[str, str] = field(default_factory=dict)
    asks_position: bool = False


class HierarchyPlayers:
    """Players for agents under commanders, with reports passed up and orders down.

    Args:
        members: the agents.
        commanders: the commanders, each after its subordinate commanders.
        cycle_seconds: duration of a cycle of the world, s.

    Attributes:
        players: the agents' players, by name.
        agents: the engine's agents for all members and commanders, by name.
    """

    def __init__(
        self,
        members: Iterable[Member],
        commanders: Iterable[Commander] = (),
        cycle_seconds: float = 0.1,
    ) -> None:
        nodes: dict[str, _Node] = {}
        self.players: dict[str, _Member] = {}
        for member in members:
            agent = Agent(member.name, member.library.domain, member.library)
            player = _Member(agent, member.behavior, cycle_seconds)
            nodes[member.name] = self.players[member.name] = player
        self._commanders: list[_CommanderNode] = []
        for commander in commanders:
            agent = Agent(commander.name, commander_domain(commander.kind), commander.library)
            node = _CommanderNode(
                agent,
                commander,
                [nodes[name] for name in commander.subordinates],
            )
            nodes[commander.name] = node
            self._commanders.append(node)
        self.agents: Mapping[str, Agent] = {name: node.agent for name, node in nodes.items()}
        self._round = 0

    def confer(self) -> None:
        """Pass reports up and orders down, after all have perceived and before any acts."""
        self._round += 1
        for member in self.players.values():
            member.report(self._round)
        for commander in self._commanders:
            commander.report(self._round)
        for commander in reversed(self._commanders):
            commander.decide()


class _Node:
    """An agent with its link to its commander, if it has one."""

    def __init__(self, agent: Agent, behavior: str) -> None:
        self.agent = agent
        self.subordinate = Subordinate(agent)
        self.superior: _CommanderNode | None = None
        self._restart = self._restarted = False
        if behavior:
            agent.perform(Term.parse(behavior))

    def begin(self, seed: int, episode: int) -> None:
        self.subordinate.seed, self.subordinate.episode = seed, episode
        self._restart = True

    def perceive(
        self, values: Sequence[float], heard: Sequence[str], cycle: int, seconds: float
    ) -> None:
        self.subordinate.seconds = seconds
        self.agent.sense(values, heard, cycle, seconds)
        self._restarted, self._restart = self._restart, False
        if self._restarted:
            self.agent.restart(self.subordinate.seed, self.subordinate.episode)

    def report(self, number: int) -> None:
        if self.superior is not None:
            self.superior.hear(
                self.subordinate.round_begins(number, look=False, restart=self._restarted)
            )


class _Member(_Node):
    """A player (`hitab_world.inprocess.Player`), which is also its own body."""

    def __init__(self, agent: Agent, behavior: str, cycle_seconds: float) -> None:
        super().__init__(agent, behavior)
        self.body = self
        self.tick, self.act = agent.tick, agent.body.act
        self._cycle_seconds = cycle_seconds
        self._cycle = 0

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        self.perceive(values, heard, self._cycle, self._cycle * self._cycle_seconds)
        self._cycle += 1


class _CommanderNode(_Node):
    """A commander in a process, the counterpart of `hitab_commander.commander_link`."""

    def __init__(
        self,
        agent: Agent,
        made: Commander,
        subordinates: Sequence[_Node],
    ) -> None:
        super().__init__(agent, made.behavior)
        body = agent.body
        assert isinstance(body, CommanderBody)
        self._body = body
        self._lockstep = Lockstep(body)
        self._subordinates = subordinates
        self._present: Round | None = None
        names = [node.agent.name for node in subordinates]
        roles = {name: made.roles.get(name, "") for name in names}
        body.enlist(roles, 1, asks_position=made.asks_position)
        for node in subordinates:
            node.subordinate.role = roles[node.agent.name]
            node.superior = self
            # A commander asks for values before it orders anything.
            node.subordinate.take(body.order)

    def hear(self, report: Report) -> None:
        _, complete = self._lockstep.hear(report, 0.0)
        if complete is not None:
            self._present = complete
            if complete.restart:
                self.begin(complete.seed, complete.episode)
            self.perceive((), (), complete.cycle, complete.seconds)

    def decide(self) -> None:
        present = self._present
        assert present is not None, "its subordinates have reported before"
        if self._lockstep.is_due(present):
            with suppress(FeatureValueError):  # the commander does nothing then, as its node would
                self.agent.tick()
        order = replace(self._body.order, round=present.number)
        for node in self._subordinates:
            if node.subordinate.take(order) and isinstance(node, _CommanderNode):
                node._lockstep.expect()
