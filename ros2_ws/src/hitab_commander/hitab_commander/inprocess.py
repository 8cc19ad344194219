"""Play swarms with commanders in one process: the same bodies and engine, without ROS.

Agents and commanders are those of `hitab_core` and of this package; only what carries reports and
orders differs: here they are handed over at once. Players are made for `hitab_world.inprocess`.

Example::

    world = ForagingWorld(seed=7)
    troop = Troop(
        [Member(name, library) for name in world.agents],
        [Commander("squad_1", kind, squad_library, "SquadForage", world.agents[:5])],
    )
    results = play(world, troop.players, episodes=30)
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hitab_commander.commander_body import CommanderBody
from hitab_commander.commander_domain import commander_domain
from hitab_commander.kind import CommanderKind
from hitab_core.agent import Agent
from hitab_core.behavior_library import BehaviorLibrary
from hitab_core.errors import FeatureValueError
from hitab_core.order import Order, Report
from hitab_core.subordinate import Subordinate
from hitab_core.use import Use

SIGN_OF_LIFE_S = 1.0
"""At least so often a commander hears of each subordinate, in the world's time."""


@dataclass(frozen=True)
class Member:
    """An agent.

    Attributes:
        behavior: what it performs until it is ordered otherwise; empty: nothing.
    """

    name: str
    library: BehaviorLibrary
    behavior: str = ""


@dataclass(frozen=True)
class Commander:
    """A commander.

    Attributes:
        library: of behaviors of its kind's domain; see `commander_domain`.
        behavior: what it performs until it is ordered otherwise; empty: nothing.
        subordinates: names of agents, or of commanders that were listed before.
    """

    name: str
    kind: CommanderKind
    library: BehaviorLibrary
    behavior: str
    subordinates: tuple[str, ...]


class TroopPlayer:
    """Plays one agent of a troop; see `hitab_world.inprocess.Player`."""

    def __init__(self, node: _Node, cycle_seconds: float) -> None:
        self._node = node
        self._cycle_seconds = cycle_seconds
        self._cycle = 0
        self.body = self

    def begin(self, seed: int, episode: int) -> None:
        """Begin an episode, at Start; so do its commanders, told by its first report."""
        self._node.restart(seed, episode)

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take a percept."""
        self._cycle += 1
        self._node.agent.sense(values, heard, self._cycle)

    def tick(self) -> None:
        """Act on the percept, and report to the commander if there is news."""
        self._node.agent.tick()
        self._node.tell(self._cycle * self._cycle_seconds)

    def act(self) -> tuple[Sequence[float], str]:
        """Return what the agent does."""
        return self._node.agent.act()


class Troop:
    """Agents and their commanders, handing reports up and orders down.

    Args:
        members: the agents.
        commanders: subordinate ones before their own commanders.
        cycle_seconds: of the world that is played in, s.

    Attributes:
        players: by agent.
        agents: the engine's agents, of all members and commanders, by name.
    """

    def __init__(
        self,
        members: Iterable[Member],
        commanders: Iterable[Commander] = (),
        cycle_seconds: float = 0.1,
    ) -> None:
        nodes: dict[str, _Node] = {}
        for member in members:
            agent = Agent(member.name, member.library.domain, member.library)
            nodes[member.name] = _Node(agent, member.behavior)
        self.players = {name: TroopPlayer(node, cycle_seconds) for name, node in nodes.items()}
        for commander in commanders:
            agent = Agent(commander.name, commander_domain(commander.kind), commander.library)
            node = _CommanderNode(
                agent, commander.behavior, {name: nodes[name] for name in commander.subordinates}
            )
            nodes[commander.name] = node
        self.agents: Mapping[str, Agent] = {name: node.agent for name, node in nodes.items()}


class _Node:
    """An agent with its link to its commander, if it has one."""

    def __init__(self, agent: Agent, behavior: str) -> None:
        self.agent = agent
        self.subordinate = Subordinate(agent)
        self.superior: _CommanderNode | None = None
        self._told_at = -math.inf
        if behavior:
            agent.perform(Use.parse(behavior))

    def restart(self, seed: int, episode: int) -> None:
        self.subordinate.seed, self.subordinate.episode = seed, episode
        self.agent.restart(seed, episode)
        if self.superior is not None:
            self.superior.restart(seed, episode)

    def tell(self, seconds: float) -> None:
        """Report to the commander if there is news, or has been none for a while."""
        self.report(self.subordinate.news(seconds), seconds)

    def report(self, news: Report | None, now: float) -> None:
        """Hand news to the commander; if there is none, a sign of life once a second."""
        if self.superior is None:
            return
        if news is None and now - self._told_at >= SIGN_OF_LIFE_S:
            news = self.subordinate.report()
        if news is not None:
            self._told_at = now
            self.superior.hear(news, now)

    def take(self, order: Order, seconds: float) -> None:
        """Obey an order, and say so."""
        if self.subordinate.take(order):
            self.tell(seconds)


class _CommanderNode(_Node):
    """A commander: decides when it hears news, as `hitab_commander.commander_link` does."""

    def __init__(self, agent: Agent, behavior: str, subordinates: dict[str, _Node]) -> None:
        super().__init__(agent, behavior)
        self.body: Any = agent.body
        assert isinstance(self.body, CommanderBody)
        self._subordinates = subordinates
        self._now = 0.0
        self._seconds = 0.0
        self._deciding = False
        self.body.enlist(dict.fromkeys(subordinates, ""), 1)
        self.body.on_order = self._send
        for node in subordinates.values():
            node.superior = self
            # It asks for values before it orders anything.
            node.subordinate.take(self.body.order)

    def restart(self, seed: int, episode: int) -> None:
        if (seed, episode) != (self.subordinate.seed, self.subordinate.episode):
            super().restart(seed, episode)

    def hear(self, report: Report, now: float) -> None:
        self._now = now
        changed = self.body.hear(report, now)
        everybody = self.body.round_ends()
        if everybody:
            self._seconds += self.body.kind.report_period
        if changed or everybody:
            self.decide()

    def decide(self) -> None:
        # What subordinates say to an order that is just being given waits for the next news.
        if not self.body.ready or self._deciding:
            return
        self._deciding = True
        self.agent.sense((), ())
        try:
            self.agent.tick()
        except FeatureValueError:  # then it does nothing this time, as its node would
            pass
        finally:
            self._deciding = False
        self.tell(self._seconds)

    def tell(self, seconds: float) -> None:
        self.report(self.subordinate.news(self._seconds), self._now)

    def take(self, order: Order, seconds: float) -> None:
        """Pass an order on at once: decide now what the subordinates are to do for it."""
        if self.subordinate.take(order):
            self.decide()
            self.tell(seconds)

    def _send(self, order: Order) -> None:
        for node in self._subordinates.values():
            node.take(order, self._now)
