"""Talks to the agents of a swarm over their public topics and services."""

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
"""Agents of a host create a service when a client appears; for so many at the same time."""


def is_answered(status: AgentStatus, sequence: int) -> bool:
    """Return whether an agent's status shows a command as taken or refused."""
    return sequence in (status.last_command_sequence, status.last_refused_sequence)


class SwarmClient(AgentPresence):
    """The agents of a swarm, as seen and commanded over ROS.

    Args:
        link: the node to use.
        expected: names of the expected agents, if known.
        prefix: namespace of the swarm.
        demonstrator: name of the demonstrator; by default, the user.
        identity: of the swarm in question; empty for any.
        processes: of the swarm; they show why an agent does not answer.

    Attributes:
        acknowledgements: of distributions.
        trainings: what the watched agents are being trained, as they have published it.
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
        """Command a behavior and wait until the agent has acknowledged it.

        Args:
            agent: to command.
            behavior: to perform.
            targets: for the behavior's parameters.
            ago: how long before what the demonstrator saw it was due, s of simulated time.
            seen: the world's cycle that the demonstrator saw; 0 for the last one.
            pace: simulated seconds per second of a person with an unknown delay;
                0: ``ago`` is known.
            unrecorded: only perform it; no example is recorded.
            sequence: number of the command, such as the time in microseconds. An agent obeys a
                number once, so a lost command can be sent again with its number. 0: a new one.
            seconds: how long to wait.
            demonstrator: who commands; empty for the client's.
            world: of the agent; None if it has none. An agent that is late in a stepped world is
                waited for: it would take the command for an answer to an earlier percept.

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

        # The subscriber may be an agent whose death is not yet known; its successor gets the
        # next copy. An agent ignores commands obeyed before, even before a crash.
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
            SwarmError: with the agent's message, if it refuses.
        """
        await self.await_agent.coroutine(agent)
        answer = await self.link.call.coroutine(
            kind,
            names.of_agent(agent, service, self.prefix),
            kind.Request(**fields),
            missing=lambda: self._absence(agent, DISCOVERY_SECONDS),
            where=agent,
        )
        # The status was sent before the answer, on another way. Until it has come, the next
        # command would be given as to the agent that was.
        await self.link.until(lambda: self._shows(agent, answer), ACKNOWLEDGE_SECONDS, 0.01)
        return answer

    def _shows(self, agent: str, answer: Any) -> bool:
        """Whether the status of an agent shows its answer."""
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
        """Return what an agent is being trained, as it is after all that was asked of it here.

        Args:
            agent: that is trained.
            searched: whether to wait until the agent has looked for questions.

        Raises:
            SwarmError: if it is not training anything, or does not publish it.
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
        """Keep what an agent is being trained in `trainings` from now on."""
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
        from hitab_client.learned import training_of  # here because it loads what learns

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
        """Give up an agent's training with its unsaved examples; the agent is idle afterwards."""
        return await self.ask.coroutine(
            agent, SetMode, names.SET_MODE, mode=AgentStatus.IDLE, discard=True
        )

    @blocking
    async def undo(self, agent: str) -> Any:
        """Take back the last command or edit."""
        return await self._edit(agent, EditExamples.Request.UNDO)

    @blocking
    async def redo(self, agent: str) -> Any:
        """Do again what was taken back last."""
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
        """Have the commands of examples be due so many seconds before they were given."""
        return await self._edit(agent, EditExamples.Request.RETIME, numbers=list(numbers), ago=ago)

    @blocking
    async def choose_features(self, agent: str, features: Sequence[str]) -> Any:
        """Learn from other features of the same examples."""
        return await self._edit(agent, EditExamples.Request.FEATURES, features=list(features))

    async def _edit(self, agent: str, action: int, **fields: Any) -> Any:
        return await self.ask.coroutine(
            agent, EditExamples, names.EDIT_EXAMPLES, action=action, **fields
        )

    @blocking
    async def behavior(self, agent: str, name: str = "", **fields: Any) -> Learned:
        """Return a behavior as it was learned, or would be; see GetBehavior.srv."""
        from hitab_client.learned import learned_of  # here because it loads what learns

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
        """Say what the agent does when it is unsure; see SetCaution.srv."""
        return await self.ask.coroutine(
            agent, SetCaution, names.SET_CAUTION, when_unsure=when_unsure, distance=distance
        )

    @blocking
    async def report(self, agent: str, automaton: str = "") -> list[TrainingCost]:
        """Return what trainings cost the person, oldest first; see GetReport.srv."""
        report = await self.ask.coroutine(agent, GetReport, names.GET_REPORT, automaton=automaton)
        return list(map(cost_of, report.costs))

    @blocking
    async def save(self, agent: str, **fields: Any) -> Any:
        """Save what was trained; see SaveBehavior.srv."""
        return await self.ask.coroutine(agent, SaveBehavior, names.SAVE, **fields)

    @blocking
    async def perform(self, agent: str, behavior: str, arguments: Sequence[str] = ()) -> Any:
        """Make an agent perform a behavior, or idle if empty."""
        return await self.ask.coroutine(
            agent, Perform, names.PERFORM, behavior=behavior, arguments=list(arguments)
        )

    def reload(self, agents: Sequence[str]) -> Iterator[tuple[str, str, bool]]:
        """Make agents reload their libraries; yield each, its answer and whether it did."""
        return map(self.link.run, self.reloading(agents))

    def reloading(self, agents: Sequence[str]) -> Iterator[Turns[tuple[str, str, bool]]]:
        """Yield coroutines that do the same, to be awaited one after the other."""
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
        """Return what can be commanded, perceived and targeted."""
        return await self.ask.coroutine(agent, GetVocabulary, names.GET_VOCABULARY)

    @blocking
    async def read_features(self, agent: str, also: Sequence[str] = ()) -> Any:
        """Return what the agent perceives at the moment; see ReadFeatures.srv."""
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
            source: agent that has the behavior.
            behavior: its name.
            arguments: targets for its parameters, if it should be started.
            receivers: agents to send it to; by default all others of its domain.
            start: make them perform it.
            seconds: how long to wait for the next answer; there is no limit on the total.
            progress: called with the number of answers and of receivers.

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
