"""Client of the agents of a swarm, through their public topics and services."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from hitab_msgs.msg import AgentStatus, Command
from hitab_msgs.msg import Training as TrainingMessage
from hitab_msgs.srv import (
    AnswerQuestion,
    BeginTraining,
    Distribute,
    EditExamples,
    GetBehavior,
    GetReport,
    GetVocabulary,
    LoadLibrary,
    Perform,
    ReadFeatures,
    SaveBehavior,
    SetCaution,
    SetMode,
)

from hitab_client.acknowledgements import QUIET_SECONDS, Acknowledgements, DistributionReport
from hitab_client.agent_presence import DISCOVERY_SECONDS, AgentPresence
from hitab_client.errors import SwarmError
from hitab_client.ros_link import RosLink
from hitab_client.run_processes import RunProcesses
from hitab_client.users import user_name
from hitab_core import Fix
from hitab_ros import names, qos
from hitab_ros.call import Turns, blocking
from hitab_ros.conversions import cost_of, remedies_of

if TYPE_CHECKING:
    from hitab_client.learned import Learned, Training
    from hitab_client.world_client import WorldClient
    from hitab_core.assistant import TrainingCost

ACKNOWLEDGE_SECONDS = 10.0
RESEND_SECONDS = 0.5
DRAIN_SECONDS = 0.02
"""Time to process messages that arrived while the client was not spinning."""

PUBLISHED_SECONDS = 15.0
"""Timeout for an agent to publish its training, s; it looks for questions first."""

SERVICES_PER_BATCH = 50
"""Number of services called at the same time; a host creates each when its client appears."""


def is_answered(status: AgentStatus, sequence: int) -> bool:
    """Return whether an agent's status shows a command as taken or refused."""
    return sequence in (status.last_command_sequence, status.last_refused_sequence)


class SwarmClient(AgentPresence):
    """Client of a swarm's agents over ROS.

    Args:
        link: the node to use.
        expected: names of the expected agents, if known.
        prefix: namespace of the swarm.
        demonstrator: name of the demonstrator; by default, the user.
        identity: the swarm's identity; empty for any swarm.
        processes: the swarm's processes, which show why an agent does not answer.

    Attributes:
        acknowledgements: acknowledgements of distributions.
        trainings: last published trainings of the watched agents, by name.
    """

    def __init__(
        self,
        link: RosLink,
        expected: Iterable[str] = (),
        *,
        prefix: str = "",
        demonstrator: str = "",
        identity: str = "",
        processes: RunProcesses | None = None,
    ) -> None:
        super().__init__(link, expected, prefix=prefix, identity=identity, processes=processes)
        self.demonstrator = demonstrator or user_name()
        self._publishers: dict[str, Any] = {}
        self._sequence = 0
        self.acknowledgements = Acknowledgements(link, prefix)
        self.trainings: dict[str, Training] = {}
        self._followed: dict[str, Any] = {}

    # -- commanding -------------------------------------------------------------------------

    @blocking
    async def command(
        self,
        agent: str,
        behavior: str,
        targets: Sequence[str] = (),
        *,
        ago: float = 0.0,
        seen: int = 0,
        pace: float = 0.0,
        unrecorded: bool = False,
        sequence: int = 0,
        seconds: float = ACKNOWLEDGE_SECONDS,
        demonstrator: str = "",
        world: WorldClient | None = None,
    ) -> AgentStatus:
        """Command a behavior and wait for the agent's acknowledgement.

        Args:
            agent: name of the agent.
            behavior: behavior to perform.
            targets: targets of the behavior's parameters.
            ago: time from when the command was due to the cycle that the demonstrator saw, s of
                simulated time.
            seen: the world's cycle that the demonstrator saw; 0 for the last one.
            pace: simulated seconds per second, if the person's delay is unknown; 0 if ``ago`` is
                known.
            unrecorded: whether to perform the behavior without recording an example.
            sequence: the command's number, such as the time in microseconds; 0 for a new number.
                An agent obeys a number once, so a lost command can be sent again with its number.
            seconds: timeout.
            demonstrator: name of the demonstrator; empty for the client's own.
            world: client of the agent's world; None without a world. In a stepped world, a late
                agent is waited for, since it would relate the command to an earlier percept.

        Raises:
            SwarmError: if the agent is missing, refuses, or does not acknowledge.
        """
        await self.await_agent.coroutine(agent)
        if world is not None and world.is_paused:
            await self.link.until(lambda: agent not in world.missing, seconds)
        publisher = await self._commander(agent)
        if not sequence:
            sequence = self._sequence = max(self._sequence + 1, time.time_ns() // 1000)
        command = Command(
            sequence=sequence,
            demonstrator=demonstrator or self.demonstrator,
            behavior=behavior,
            targets=list(targets),
            ago=ago,
            seen=seen,
            pace=pace,
            unrecorded=unrecorded,
        )

        def answered() -> bool:
            return is_answered(self.statuses[agent], sequence)

        # The subscriber may be an agent whose crash is not detected yet; its successor gets the
        # next copy. An agent ignores repeated commands, even after a restart.
        if not await self.link.repeat(
            lambda: publisher.publish(command),
            answered,
            seconds,
            RESEND_SECONDS,
            over=lambda: self.processes.is_lost(agent),
        ):
            late = f"{agent} did not acknowledge the command within {seconds:g} s"
            raise self.processes.reason(agent) or SwarmError(late, Fix.EXAMPLES(agent=agent))
        status = self.statuses[agent]
        if status.last_refused_sequence == sequence:
            remedies = remedies_of(status.last_remedies)
            raise SwarmError(status.last_error, *remedies, where=agent)
        return status

    async def _commander(self, agent: str) -> Any:
        topic = names.of_agent(agent, names.COMMAND, self.prefix)
        publisher = self._publishers.get(agent)
        if publisher is None:
            publisher = self.link.node.create_publisher(Command, topic, qos.EVENTS)
            self._publishers[agent] = publisher
        # A reliable writer reaches only matched readers: wait for the agent's.
        if not await self.link.until(
            lambda: publisher.get_subscription_count() > 0,
            DISCOVERY_SECONDS,
            0.01,
            lambda: f"{agent} to listen",
        ):
            raise self._absence(agent, DISCOVERY_SECONDS)
        return publisher

    # -- services ---------------------------------------------------------------------------

    @blocking
    async def ask(self, agent: str, kind: Any, service: str, **fields: Any) -> Any:
        """Call one of an agent's services and return its answer.

        Raises:
            SwarmError: if the agent refuses, with its message.
        """
        await self.await_agent.coroutine(agent)
        answer = await self.link.call.coroutine(
            kind,
            names.of_agent(agent, service, self.prefix),
            kind.Request(**fields),
            missing=lambda: self._absence(agent, DISCOVERY_SECONDS),
            where=agent,
        )
        # The status was sent before the answer, on another topic. Until it arrives, the next
        # command would rely on the agent's former status.
        await self.link.until(lambda: self._shows(agent, answer), ACKNOWLEDGE_SECONDS, 0.01)
        return answer

    def _shows(self, agent: str, answer: Any) -> bool:
        """Whether an agent's status is as recent as its answer."""
        status = self.statuses.get(agent)
        if status is None:
            return True
        if isinstance(answer, Perform.Response):
            return status.mode not in (AgentStatus.TRAINING, AgentStatus.TESTING)
        ended = 0 if isinstance(answer, SaveBehavior.Response) else None
        revision = getattr(answer, "revision", ended)
        return revision is None or bool(
            status.training_revision >= revision if revision else not status.training
        )

    # -- training ---------------------------------------------------------------------------

    @blocking
    async def training(self, agent: str, *, searched: bool = False) -> Training:
        """Return an agent's training, up to date with all requests of this client.

        Args:
            agent: name of the agent.
            searched: whether to wait until the agent has searched for questions.

        Raises:
            SwarmError: if the agent has no training, or does not publish it.
        """
        await self.await_agent.coroutine(agent)
        await self.link.until(lambda: False, DRAIN_SECONDS, DRAIN_SECONDS)

        def has_come() -> bool:
            self.watch_training(agent)
            wanted, training = self.statuses[agent].training_revision, self.trainings.get(agent)
            if not wanted or training is None:
                return not wanted
            return training.revision >= wanted and (training.searched or not searched)

        if not await self.link.until(
            has_come, PUBLISHED_SECONDS, 0.01, lambda: f"what {agent} is being trained"
        ):
            raise self.processes.reason(agent) or SwarmError(
                "it does not publish its training", Fix.LOGS(node=agent), where=agent
            )
        if not self.statuses[agent].training_revision:
            raise SwarmError(
                "it is not training anything",
                Fix.RESUME(agent=agent),
                Fix.TRAIN(agent=agent),
                where=agent,
            )
        return self.trainings[agent]

    def watch_training(self, agent: str) -> None:
        """Keep an agent's training in `trainings` from now on."""
        if agent not in self._followed:
            topic = names.of_agent(agent, names.TRAINING, self.prefix)
            self._followed[agent] = self.link.subscribe(
                TrainingMessage, topic, self._take_training, qos.LATCHED, temporary=True
            )

    def forget_training(self, agent: str) -> None:
        """End the agent's publishing of its training for this client."""
        if (subscription := self._followed.pop(agent, None)) is not None:
            self.link.node.destroy_subscription(subscription)
            self.trainings.pop(agent, None)

    def _take_training(self, message: TrainingMessage) -> None:
        from hitab_client.learned import training_of  # deferred: loads the learning code

        if message.automaton.name:
            self.trainings[message.agent] = training_of(message)
        else:
            self.trainings.pop(message.agent, None)

    @blocking
    async def begin(self, agent: str, automaton: str, **fields: Any) -> Any:
        """Begin to train an automaton; see BeginTraining.srv."""
        return await self.ask.coroutine(
            agent, BeginTraining, names.BEGIN, automaton=automaton, **fields
        )

    @blocking
    async def set_mode(self, agent: str, mode: str, *, restart: bool = False) -> Any:
        """Switch between training and testing."""
        return await self.ask.coroutine(agent, SetMode, names.SET_MODE, mode=mode, restart=restart)

    @blocking
    async def discard(self, agent: str) -> Any:
        """Discard an agent's training with its unsaved examples; the agent is idle afterwards."""
        return await self.ask.coroutine(
            agent, SetMode, names.SET_MODE, mode=AgentStatus.IDLE, discard=True
        )

    @blocking
    async def undo(self, agent: str) -> Any:
        """Undo the last command or edit."""
        return await self._edit(agent, EditExamples.Request.UNDO)

    @blocking
    async def redo(self, agent: str) -> Any:
        """Redo the last command or edit that was undone."""
        return await self._edit(agent, EditExamples.Request.REDO)

    @blocking
    async def delete(self, agent: str, numbers: Sequence[int]) -> Any:
        """Remove examples."""
        return await self._edit(agent, EditExamples.Request.DELETE, numbers=list(numbers))

    @blocking
    async def relabel(self, agent: str, numbers: Sequence[int], state: str) -> Any:
        """Change the next state of examples."""
        edit = EditExamples.Request.RELABEL
        return await self._edit(agent, edit, numbers=list(numbers), next_state=state)

    @blocking
    async def retime(self, agent: str, numbers: Sequence[int], ago: float) -> Any:
        """Date the commands of examples back by some seconds."""
        return await self._edit(agent, EditExamples.Request.RETIME, numbers=list(numbers), ago=ago)

    @blocking
    async def choose_features(self, agent: str, features: Sequence[str]) -> Any:
        """Choose other features to learn from, with the same examples."""
        return await self._edit(agent, EditExamples.Request.FEATURES, features=list(features))

    async def _edit(self, agent: str, action: int, **fields: Any) -> Any:
        return await self.ask.coroutine(
            agent, EditExamples, names.EDIT_EXAMPLES, action=action, **fields
        )

    @blocking
    async def behavior(self, agent: str, name: str = "", **fields: Any) -> Learned:
        """Return a learned behavior, or a preview of one; see GetBehavior.srv."""
        from hitab_client.learned import learned_of  # deferred: loads the learning code

        return learned_of(
            await self.ask.coroutine(agent, GetBehavior, names.GET_BEHAVIOR, name=name, **fields)
        )

    @blocking
    async def answer(
        self, agent: str, number: int, choice: str = "", *, dismiss: bool = False
    ) -> Any:
        """Answer a question of the agent; see AnswerQuestion.srv."""
        return await self.ask.coroutine(
            agent,
            AnswerQuestion,
            names.ANSWER_QUESTION,
            number=number,
            choice=choice,
            dismiss=dismiss,
        )

    @blocking
    async def set_caution(self, agent: str, when_unsure: str, *, distance: float = 0.0) -> Any:
        """Set the agent's reaction to unsure decisions; see SetCaution.srv."""
        return await self.ask.coroutine(
            agent, SetCaution, names.SET_CAUTION, when_unsure=when_unsure, distance=distance
        )

    @blocking
    async def report(self, agent: str, automaton: str = "") -> list[TrainingCost]:
        """Return the costs of trainings, oldest first; see GetReport.srv."""
        report = await self.ask.coroutine(agent, GetReport, names.GET_REPORT, automaton=automaton)
        return list(map(cost_of, report.costs))

    @blocking
    async def save(self, agent: str, **fields: Any) -> Any:
        """Save the trained behavior; see SaveBehavior.srv."""
        return await self.ask.coroutine(agent, SaveBehavior, names.SAVE, **fields)

    @blocking
    async def perform(self, agent: str, behavior: str, arguments: Sequence[str] = ()) -> Any:
        """Make an agent perform a behavior, or idle if empty."""
        return await self.ask.coroutine(
            agent, Perform, names.PERFORM, behavior=behavior, arguments=list(arguments)
        )

    def reload(self, agents: Sequence[str]) -> Iterator[tuple[str, str, bool]]:
        """Make agents reload their libraries; yield each agent, its answer and its success."""
        return map(self.link.run, self.reloading(agents))

    def reloading(self, agents: Sequence[str]) -> Iterator[Turns[tuple[str, str, bool]]]:
        """Yield a coroutine per agent that reloads its library, to be awaited in turn."""
        for start in range(0, len(agents), SERVICES_PER_BATCH):
            together = agents[start : start + SERVICES_PER_BATCH]
            for agent in together:
                service = names.of_agent(agent, names.LOAD_LIBRARY, self.prefix)
                self.link.will_call(LoadLibrary, service)
            yield from map(self._reload, together)

    async def _reload(self, agent: str) -> tuple[str, str, bool]:
        try:
            return agent, (await self.load_library.coroutine(agent)).message, True
        except SwarmError as error:
            return agent, error.what, False

    @blocking
    async def load_library(self, agent: str, path: str = "") -> Any:
        """Make an agent reload its library, or load another one."""
        return await self.ask.coroutine(agent, LoadLibrary, names.LOAD_LIBRARY, path=path)

    @blocking
    async def vocabulary(self, agent: str) -> Any:
        """Return an agent's behaviors, features and targets."""
        return await self.ask.coroutine(agent, GetVocabulary, names.GET_VOCABULARY)

    @blocking
    async def read_features(self, agent: str, also: Sequence[str] = ()) -> Any:
        """Return the current values of an agent's features; see ReadFeatures.srv."""
        return await self.ask.coroutine(agent, ReadFeatures, names.READ_FEATURES, also=list(also))

    # -- distributing -----------------------------------------------------------------------

    @blocking
    async def distribute(
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
            source: name of the agent that has the behavior.
            behavior: name of the behavior.
            arguments: targets of the behavior's parameters, if it is to be started.
            receivers: names of the receivers; by default all other agents of the source's domain.
            start: whether the receivers perform the behavior.
            seconds: timeout for each next answer; the total is not limited.
            progress: called with the numbers of answers and of receivers.

        Raises:
            SwarmError: if the source refuses, or a receiver is missing.
        """
        if not receivers:
            await self.await_agents.coroutine()
        for agent in (source, *receivers):
            await self.await_agent.coroutine(agent)
        chosen = [name for name in receivers or self.mates_of(source) if name != source]
        if not chosen:
            raise SwarmError(f"there is no other agent of the domain of {source} to send it to")
        await self.acknowledgements.await_hearing(chosen)
        answer = await self.ask.coroutine(
            source,
            Distribute,
            names.DISTRIBUTE,
            behavior=behavior,
            arguments=list(arguments),
            receivers=chosen,
            start=start,
        )
        report = await self.acknowledgements.gather(
            answer.sequence, answer.digest, chosen, seconds, progress
        )
        report.message = answer.message
        return report
