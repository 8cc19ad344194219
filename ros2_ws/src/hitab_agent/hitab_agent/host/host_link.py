"""The link of a host's agents to a world: one message of percepts in, one of actions out."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from types import SimpleNamespace
from typing import Any

from hitab_msgs import msg
from rclpy.qos import QoSProfile, ReliabilityPolicy

from hitab_agent.host.roster_topic import RosterTopic
from hitab_agent.links.order_exchange import Exchange
from hitab_agent.links.round_gate import RoundGate
from hitab_agent.node.agent_base import AgentBase
from hitab_agent.node.guarded_tick import NO_ACTION
from hitab_ros import GuardedNode, names, qos
from hitab_ros.messages.checks import too_far_ahead
from hitab_ros.messages.pieces import PieceReader, publish_pieces
from hitab_ros.messages.stamps import seconds_of

LATEST_ONLY_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""A host that was delayed answers only the latest percepts."""

Failures = dict[AgentBase, Exception]
Send = Callable[[msg.ActionBatch], object]

SEQUENCES_OF_ONE_WORLD = 1000
"""A world numbers its cycles in turn from the time at which it began, ns: percepts with a number
that is lower by more are those of another world."""

_FIELDS = msg.PerceptBatch.get_fields_and_field_types()
CYCLE_FIELDS = tuple(
    field
    for field in msg.Percept.get_fields_and_field_types()
    if field in _FIELDS and field not in ("values", "heard")
)
"""Fields that all percepts of a cycle share."""


class HostLink:
    """Answers the percepts of all agents of a host.

    In lockstep, all perceive, their commanders give orders, and all act. In real time, each agent
    acts as soon as it has perceived, while its data are still in the processor's cache.
    """

    def __init__(
        self,
        host: GuardedNode,
        name: str,
        world: str,
        exchange: Exchange,
        nodes: Sequence[AgentBase],
        roster: RosterTopic,
    ) -> None:
        """Create the publisher; no percepts arrive before `listen`.

        Args:
            host: a node of the process, in the swarm's namespace or in one of its own below it.
            name: the host's name, unique in the swarm.
            world: name of the world.
            exchange: the process's exchange, which is held while all act.
            nodes: the nodes of all agents of the host, in the order of its roster.
            roster: the roster, to which the percepts refer.
        """
        self._host = host
        self._name = name
        self._exchange = exchange
        self._gate = RoundGate(exchange)
        self._nodes = nodes
        self._roster = roster
        # Has the fields of a `msg.Percept`, without the message's checks at each assignment.
        self._percept = SimpleNamespace()
        self._sequence = 0  # of the latest percepts
        self._episodes: dict[int, tuple[int, int]] = {}  # of each agent's last percept
        self._failing: set[str] = set()  # the parts of a batch in which some agent failed last
        self._actions = host.create_publisher(
            msg.ActionBatch, names.in_swarm(host, world, names.ACTION_BATCHES), qos.CYCLE
        )
        self._pieces: Any = None
        if roster.machine:
            self._pieces = host.create_publisher(
                msg.ActionBatch, names.in_swarm(host, world, names.ACTION_PIECES), qos.PIECES
            )
        self._answers = msg.ActionBatch(host=name)

    def listen(self) -> None:
        """Listen to the world."""
        self._host.create_subscription(
            msg.PerceptBatch,
            names.in_swarm(self._host, self._name, names.PERCEPTS),
            self._on_percepts,
            LATEST_ONLY_QOS,
        )
        if self._pieces is not None:
            self._host.create_subscription(
                msg.PerceptBatch,
                names.in_swarm(self._host, self._name, names.PERCEPT_PIECES),
                self._on_piece,
                qos.PIECES,
                read=PieceReader(msg.PerceptBatch),
            )

    def _on_piece(self, batch: msg.PerceptBatch) -> None:
        self._on_percepts(batch, lambda answer: publish_pieces(self._pieces, [answer]))

    def _on_percepts(self, batch: msg.PerceptBatch, send: Send | None = None) -> None:
        if batch.roster != self._roster.number:
            # The percepts are meant for an earlier process of this name or, if the number is
            # higher, for a roster that another process has published in this host's name.
            if batch.roster > self._roster.number and not too_far_ahead(batch.roster):
                self._roster.publish(batch.roster)
            return
        if not _is_sound(batch, len(self._nodes)):
            self._host.guard.log(
                "ignored percepts whose agents, counts and values do not match; their sender must "
                "fill them in as msg/PerceptBatch says"
            )
            return
        if 0 < self._sequence - batch.sequence < SEQUENCES_OF_ONE_WORLD:
            return  # overtaken by a later cycle
        self._sequence = batch.sequence
        percept = self._percept
        for field in CYCLE_FIELDS:
            setattr(percept, field, getattr(batch, field))
        perceiving: Iterable[AgentBase] = self._perceive(batch)
        commanders: set[str] = set()
        if batch.lockstep:
            with self._exchange.at_once():
                perceiving = list(perceiving)
            commanders.update(*(node.awaited_orders() for node in perceiving))
        self._gate.begin(
            batch.sequence,
            commanders,
            lambda: self._answer(batch, perceiving, send or self._actions.publish),
            look=batch.look,
        )

    def _perceive(self, batch: msg.PerceptBatch) -> Iterator[AgentBase]:
        """Make all agents of a batch take in their percepts; yield each after its own."""
        percept, seconds = self._percept, seconds_of(batch.stamp)
        episode, episodes = (batch.seed, batch.episode), self._episodes
        acting = [self._nodes[index] for index in batch.agents]
        heard_counts = batch.heard_counts or (0,) * len(acting)
        values, all_heard, end, heard_end = batch.values, batch.heard, 0, 0
        failures: Failures = {}
        for index, node, count, n_heard in zip(
            batch.agents, acting, batch.value_counts, heard_counts, strict=True
        ):
            # The world skips late answers, and percepts are skipped or lost: a restart may be in
            # one of them.
            percept.restart = batch.restart or episodes.get(index, episode) != episode
            episodes[index] = episode
            begin, end = end, end + count
            heard, heard_end = heard_end, heard_end + n_heard
            percept.values = values[begin:end]
            percept.heard = all_heard[heard:heard_end]
            try:
                node.take_in(percept, seconds)
            except Exception as error:
                failures[node] = error
            yield node
        self._report("perceiving", acting, failures)

    def _answer(
        self, batch: msg.PerceptBatch, perceiving: Iterable[AgentBase], send: Send
    ) -> None:
        """Make each agent act once it has perceived, and send the answer."""
        answers, percept, acting = self._answers, self._percept, []
        failures: Failures = {}
        with self._exchange.held():
            done, counts = array("d"), array("I")
            speakers, taught, holders = array("I"), array("I"), array("I")
            said, holds = list[str](), list[str]()
            for index, node in zip(batch.agents, perceiving, strict=True):
                acting.append(node)
                try:
                    action, say = node.answer(percept)
                except Exception as error:
                    failures[node] = error
                    action, say = NO_ACTION
                done.extend(action)
                counts.append(len(action))
                if say:
                    speakers.append(index)
                    said.append(say)
                if node.taught:
                    taught.append(index)
                if hold := node.hold:
                    holders.append(index)
                    holds.append(hold)
            self._report("acting", acting, failures)
        answers.roster, answers.sequence = batch.roster, batch.sequence
        answers.agents = batch.agents
        answers.value_counts = counts
        answers.values = done
        answers.speakers = speakers
        answers.said = said
        answers.taught = taught
        answers.holders = holders
        answers.holds = holds
        send(answers)

    def _report(self, key: str, acting: Sequence[AgentBase], failures: Failures) -> None:
        """Show the fault of each failing agent until it succeeds, as its guard would.

        A guard around each agent's part would cost more than most of the parts.
        """
        if not failures and key not in self._failing:
            return
        self._failing.discard(key)
        for node in acting:
            if node in failures:
                node.guard.failed(key, failures[node])
            else:
                node.guard.faults.clear(key)
        if any(key in node.guard.faults.by_key for node in self._nodes):
            self._failing.add(key)


def _is_sound(batch: msg.PerceptBatch, agents: int) -> bool:
    """Whether the counts of a batch match its contents and the number of agents."""
    counts, heard_counts = batch.value_counts, batch.heard_counts
    return (
        len(counts) == len(batch.agents)
        and len(heard_counts) in (0, len(counts))
        and max(batch.agents, default=0) < agents
        and sum(counts) == len(batch.values)
        and sum(heard_counts) == len(batch.heard)
    )
