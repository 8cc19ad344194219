"""Talks to the agents of a swarm over their public topics and services."""

from __future__ import annotations

import getpass
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hitab_msgs.msg import AgentStatus, Command, DistributionAck
from hitab_msgs.srv import (
    BeginTraining,
    Distribute,
    EditExamples,
    GetVocabulary,
    ListExamples,
    LoadLibrary,
    Perform,
    SaveBehavior,
    SetMode,
)

from hitab_client.errors import SwarmError
from hitab_client.identity import is_own, other_swarm
from hitab_client.ros_link import RosLink
from hitab_core import has
from hitab_ros import names, qos, refuse_other_definitions

DISCOVERY_SECONDS = 8.0
"""Nodes usually discover each other within a second, but it may take several."""

DISCOVERY_SECONDS_EACH = 0.02
"""Added per agent of a swarm, since discovery time grows with the swarm."""

WATCHED_MAX = 100
"""In a larger swarm only the requested agents are watched."""

SETTLE_SECONDS = 1.5
ACKNOWLEDGE_SECONDS = 10.0
RESEND_SECONDS = 0.5

QUIET_SECONDS = 10.0
"""Without a new acknowledgement for this long, the missing ones will not come."""

HEARING_SECONDS = 2.0
"""How long to wait for the acknowledgement topics to connect."""


@dataclass
class DistributionReport:
    """The receivers' answers to a distribution.

    Attributes:
        sequence: number of the distribution.
        digest: given by the source.
        accepted: receivers that verified the same digest.
        refused: receivers that refused, with their reasons.
        silent: receivers that did not answer.
    """

    sequence: int
    digest: str
    accepted: list[str] = field(default_factory=list)
    refused: dict[str, str] = field(default_factory=dict)
    silent: list[str] = field(default_factory=list)

    @property
    def complete(self) -> bool:
        """Whether every receiver has it."""
        return not self.refused and not self.silent


class SwarmClient:
    """The agents of a swarm, as seen and commanded over ROS.

    Args:
        link: the node to use.
        expected: names of the expected agents, if known.
        prefix: namespace of the swarm.
        demonstrator: name of the demonstrator; by default, the user.
        identity: of the swarm in question; empty: any.

    Attributes:
        statuses: the last status of each agent of the swarm, by name.
        strangers: the swarm of each agent that belongs to another swarm, by name.
    """

    def __init__(
        self,
        link: RosLink,
        expected: Iterable[str] = (),
        *,
        prefix: str = "",
        demonstrator: str = "",
        identity: str = "",
    ) -> None:
        self.link = link
        self.prefix = prefix
        self.expected = tuple(expected)
        self.demonstrator = demonstrator or getpass.getuser()
        self.identity = identity
        self.statuses: dict[str, AgentStatus] = {}
        self.strangers: dict[str, str] = {}
        self._watched: set[str] = set()
        self._publishers: dict[str, Any] = {}
        self._acks: dict[int, dict[str, DistributionAck]] = {}
        self._sequence = 0
        if len(self.expected) <= WATCHED_MAX:
            self.watch_all()
        link.subscribe(
            DistributionAck,
            names.of_swarm(names.DISTRIBUTION_ACK, prefix),
            self._take_ack,
            qos.ROLL_CALL,
        )

    # -- who is there -----------------------------------------------------------------------

    def watch_all(self) -> None:
        """Watch all expected agents, however many."""
        for agent in self.expected:
            self._watch(agent)

    def _watch(self, agent: str) -> None:
        if agent not in self._watched:
            self._watched.add(agent)
            self.link.subscribe(
                AgentStatus,
                names.of_agent(agent, names.STATUS, self.prefix),
                lambda status: self._take_status(agent, status),
                qos.LATCHED,
            )

    def _take_status(self, agent: str, status: AgentStatus) -> None:
        if is_own(status.swarm, self.identity, started_by_it=agent in self.expected):
            self.statuses[agent] = status
            self.strangers.pop(agent, None)
        else:
            self.strangers[agent] = status.swarm
            self.statuses.pop(agent, None)

    def refuse_strangers(self, agents: Iterable[str]) -> None:
        """Raise if one of these agents is known to belong to another swarm.

        Raises:
            SwarmError: naming both swarms.
        """
        for agent in agents:
            if agent in self.strangers:
                raise SwarmError(other_swarm(agent, self.strangers[agent], self.identity))

    def _take_ack(self, ack: DistributionAck) -> None:
        self._acks.setdefault(ack.sequence, {})[ack.agent] = ack

    def discover(self) -> None:
        """Look for new agents."""
        for topic in self.link.topics_of_type(names.STATUS_TYPE):
            agent = names.agent_of_status(topic, self.prefix)
            if agent is not None:
                self._watch(agent)

    def agents(self) -> list[str]:
        """Return the names of the agents that have reported so far."""
        return sorted(self.statuses)

    def await_agents(
        self, agents: Sequence[str] = (), seconds: float = DISCOVERY_SECONDS
    ) -> list[str]:
        """Wait for these agents, or else for the expected ones, and return those that are up.

        If none are expected, wait until no new agent has appeared for a while.

        Raises:
                SwarmError: if one of them belongs to another swarm.
        """
        wanted = set(agents or self.expected)
        for agent in wanted:
            self._watch(agent)
        newest = (0, time.monotonic())
        few = bool(agents) and len(self.expected) > WATCHED_MAX

        def complete() -> bool:
            nonlocal newest
            if not few:
                self.discover()
            if wanted:
                self.refuse_strangers(wanted)
                return wanted <= self.statuses.keys()
            if len(self.statuses) != newest[0]:
                newest = (len(self.statuses), time.monotonic())
            return newest[0] > 0 and time.monotonic() > newest[1] + SETTLE_SECONDS

        self.link.spin_until(complete, seconds + DISCOVERY_SECONDS_EACH * len(self.expected))
        refuse_other_definitions(self.link.node)
        return self.agents()

    def await_agent(self, agent: str, seconds: float = DISCOVERY_SECONDS) -> AgentStatus:
        """Wait for an agent and return its status.

        Raises:
            SwarmError: if no such agent answers, naming those that do, or if it belongs to another
                swarm.
        """
        self.refuse_strangers((agent,))
        if agent not in self.statuses:
            self._watch(agent)
            known = bool(self.expected) and agent not in self.expected
            # An agent missing from the description may have been started by hand.
            self.await_agents(() if known else (agent,), seconds)
            if known and agent not in self.statuses:
                self.link.spin_until(lambda: agent in self.statuses, 0.5)
        self.refuse_strangers((agent,))
        if agent not in self.statuses:
            raise SwarmError(self._missing(agent))
        return self.statuses[agent]

    def _missing(self, agent: str) -> str:
        there = self.agents()
        if not there:
            return (
                f'no agent "{agent}" answers, and no other does; is the swarm up? '
                "`hitab up SWARM.yaml` starts one"
            )
        return f'no agent "{agent}" answers {has(there, agent)}; is the swarm up? `hitab status`'

    # -- commanding -------------------------------------------------------------------------

    def command(
        self,
        agent: str,
        behavior: str,
        targets: Sequence[str] = (),
        *,
        sequence: int = 0,
        seconds: float = ACKNOWLEDGE_SECONDS,
    ) -> AgentStatus:
        """Command a behavior and wait until the agent has acknowledged it.

        Args:
            agent: to command.
            behavior: that it should perform.
            targets: for the behavior's parameters.
            sequence: number of the command, such as the time in microseconds. An agent obeys a
                number once, so a lost command can be sent again with its number. 0: a new one.
            seconds: how long to wait.

        Raises:
            SwarmError: if the agent is missing, refuses, or does not acknowledge.
        """
        before = self.await_agent(agent)
        publisher = self._commander(agent)
        if not sequence:
            sequence = self._sequence = max(self._sequence + 1, time.time_ns() // 1000)
        command = Command(
            sequence=sequence,
            demonstrator=self.demonstrator,
            behavior=behavior,
            targets=list(targets),
        )

        def answered() -> bool:
            status = self.statuses[agent]
            return sequence in (status.last_command_sequence, status.last_refused_sequence)

        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            # The subscriber may be an agent whose death is not yet known; its successor gets the
            # next copy. An agent ignores commands that it has already obeyed.
            publisher.publish(command)
            if self.link.spin_until(answered, RESEND_SECONDS):
                break
            if self.statuses[agent].last_command_sequence < before.last_command_sequence:
                break  # it was restarted and does not remember obeyed commands
        if not answered():
            raise SwarmError(
                f"{agent} did not acknowledge the command within {seconds:g} s; "
                f"check with `hitab examples list {agent}` whether it was recorded"
            )
        status = self.statuses[agent]
        if status.last_refused_sequence == sequence:
            raise SwarmError(f"{agent}: {status.last_error}")
        return status

    def _commander(self, agent: str) -> Any:
        topic = names.of_agent(agent, names.COMMAND, self.prefix)
        publisher = self._publishers.get(agent)
        if publisher is None:
            publisher = self.link.node.create_publisher(Command, topic, qos.EVENTS)
            self._publishers[agent] = publisher
        # A reliable writer reaches only matched readers: wait for the agent's.
        if not self.link.spin_until(
            lambda: publisher.get_subscription_count() > 0, DISCOVERY_SECONDS, 0.01
        ):
            raise SwarmError(f"{agent} does not subscribe to {topic}; see its log")
        return publisher

    # -- services ---------------------------------------------------------------------------

    def ask(self, agent: str, kind: Any, service: str, **fields: Any) -> Any:
        """Call one of an agent's services and return its answer.

        Raises:
            SwarmError: with the agent's message, if it refuses.
        """
        self.await_agent(agent)
        answer = self.link.call(
            kind,
            names.of_agent(agent, service, self.prefix),
            kind.Request(**fields),
            missing=lambda: self._missing(agent),
        )
        if not getattr(answer, "success", True):
            raise SwarmError(f"{agent}: {answer.message}")
        return answer

    def begin(self, agent: str, automaton: str, **fields: Any) -> Any:
        """Begin to train an automaton; see BeginTraining.srv."""
        return self.ask(agent, BeginTraining, names.BEGIN, automaton=automaton, **fields)

    def set_mode(self, agent: str, mode: str, *, restart: bool = False) -> Any:
        """Switch between training and testing."""
        return self.ask(agent, SetMode, names.SET_MODE, mode=mode, restart=restart)

    def discard(self, agent: str) -> Any:
        """Give up an agent's training with its unsaved examples; the agent is idle then."""
        return self.ask(agent, SetMode, names.SET_MODE, mode=AgentStatus.IDLE, discard=True)

    def edit_examples(
        self, agent: str, action: str, numbers: Sequence[int] = (), next_state: str = ""
    ) -> Any:
        """Undo, redo, delete or relabel."""
        return self.ask(
            agent,
            EditExamples,
            names.EDIT_EXAMPLES,
            action=action,
            numbers=list(numbers),
            next_state=next_state,
        )

    def list_examples(self, agent: str, automaton: str = "") -> Any:
        """Return the examples of the current training, or of a trained behavior."""
        return self.ask(agent, ListExamples, names.LIST_EXAMPLES, automaton=automaton)

    def save(self, agent: str, **fields: Any) -> Any:
        """Save what was trained; see SaveBehavior.srv."""
        return self.ask(agent, SaveBehavior, names.SAVE, **fields)

    def perform(self, agent: str, behavior: str, arguments: Sequence[str] = ()) -> Any:
        """Make an agent perform a behavior; empty: nothing."""
        return self.ask(
            agent, Perform, names.PERFORM, behavior=behavior, arguments=list(arguments)
        )

    def load_library(self, agent: str, path: str = "") -> Any:
        """Make an agent reload its library, or load another one."""
        return self.ask(agent, LoadLibrary, names.LOAD_LIBRARY, path=path)

    def vocabulary(self, agent: str) -> Any:
        """Return what can be commanded, perceived and targeted."""
        return self.ask(agent, GetVocabulary, names.GET_VOCABULARY)

    # -- distributing -----------------------------------------------------------------------

    def distribute(
        self,
        source: str,
        behavior: str,
        *,
        arguments: Sequence[str] = (),
        receivers: Sequence[str] = (),
        start: bool = False,
        seconds: float = QUIET_SECONDS,
        progress: Callable[[int, int], None] | None = None,
    ) -> DistributionReport:
        """Send a behavior from one agent to others and wait for their answers.

        Args:
            source: agent that has the behavior.
            behavior: its name.
            arguments: targets for its parameters, if it should be started.
            receivers: agents to send it to; by default all others.
            start: make them perform it.
            seconds: how long to wait for the next answer; there is no limit on the total.
            progress: called with the number of answers and of receivers.

        Raises:
            SwarmError: if the source refuses, or a receiver is missing.
        """
        self.await_agents()
        self.await_agent(source)
        for receiver in receivers:
            self.await_agent(receiver)
        meant = [name for name in (receivers or self.agents()) if name != source]
        self._await_hearing(meant)
        answer = self.ask(
            source,
            Distribute,
            "distribute",
            behavior=behavior,
            arguments=list(arguments),
            receivers=list(receivers),
            start=start,
        )
        acks = self._acks.setdefault(answer.sequence, {})
        self._await_acks(acks, meant, seconds, progress)
        report = DistributionReport(answer.sequence, answer.digest)
        for name in meant:
            ack = acks.get(name)
            if ack is None:
                report.silent.append(name)
            elif ack.success and ack.digest == answer.digest:
                report.accepted.append(name)
            else:
                report.refused[name] = ack.message or "its files differ from those that were sent"
        return report

    def _await_hearing(self, agents: Iterable[str]) -> None:
        """Wait until acknowledgements can arrive from the processes of all these agents."""
        node = self.link.node
        topic = names.of_swarm(names.DISTRIBUTION_ACK, self.prefix)
        unheard = set(agents)

        def heard() -> bool:
            there = {_process(info) for info in node.get_publishers_info_by_topic(topic)}
            for agent in sorted(unheard):
                status = names.of_agent(agent, names.STATUS, self.prefix)
                infos = node.get_publishers_info_by_topic(status)
                if any(_process(info) in there for info in infos):
                    unheard.discard(agent)
            return not unheard

        self.link.spin_until(heard, HEARING_SECONDS, 0.01)

    def _await_acks(
        self,
        acks: Mapping[str, DistributionAck],
        meant: Sequence[str],
        seconds: float,
        progress: Callable[[int, int], None] | None,
    ) -> None:
        """Wait for all answers, as long as the next one arrives within ``seconds``."""
        wanted = set(meant)
        before = -1
        while True:
            if len(acks) != before:
                before, newest = len(acks), time.monotonic()
                if progress is not None:
                    progress(len(wanted & acks.keys()), len(wanted))
                if before >= len(wanted) and wanted <= acks.keys():
                    return
            if time.monotonic() - newest > seconds:
                return
            self.link.spin(0.05)


def _process(info: Any) -> tuple[int, ...]:
    """Return the DDS GUID prefix, which all topics of a process share."""
    return tuple(info.endpoint_gid[:12])
