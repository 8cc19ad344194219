"""Client of the agents of a swarm, through their public topics and services."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from hitab_msgs import srv
from hitab_msgs.msg import Training as TrainingMessage
from hitab_msgs.srv import GetBehavior, GetReport, GetVocabulary, ReadFeatures

from hitab_client.acknowledgements import QUIET_SECONDS, Acknowledgements, DistributionReport
from hitab_client.connecting.ros_link import RosLink
from hitab_client.errors import SwarmError
from hitab_client.runs.run_processes import RunProcesses
from hitab_client.runs.users import user_name
from hitab_client.showing.agent_presence import AgentPresence
from hitab_core import Fix
from hitab_core.codec import from_dict
from hitab_core.operations import Command, Distribute, LoadLibrary
from hitab_core.training.operation import Operation
from hitab_ros import names, qos
from hitab_ros.call import RequestRefused, Turns, blocking, turn
from hitab_ros.messages.conversions import request_of
from hitab_ros.timing import ANSWER_S, DISCOVERY_S

if TYPE_CHECKING:
    from hitab_client.learned import Learned, Training
    from hitab_client.world_client import WorldClient
    from hitab_core.assistant import TrainingCost

SERVICES_PER_BATCH = 50
"""Number of agents asked at the same time; a host creates each service when its client appears."""


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
        self.acknowledgements = Acknowledgements(link, prefix)
        self.trainings: dict[str, Training] = {}
        self._followed: dict[str, Any] = {}

    @blocking
    async def do(
        self,
        agent: str,
        operation: Operation,
        *,
        seconds: float = ANSWER_S,
        world: WorldClient | None = None,
    ) -> Any:
        """Have an agent carry out an operation, and return the answer of its service.

        Args:
            agent: name of the agent.
            operation: the operation; one without a person is this client's demonstrator's. One
                with an id may be sent again after it was lost, and is carried out once.
            seconds: timeout for the answer.
            world: client of the agent's world; None without a world. In a stepped world, a late
                agent is waited for, since it would relate a command to an earlier percept.

        Raises:
            SwarmError: if the agent is missing, does not answer, or refuses, with its message.
        """
        self.will_do(agent, type(operation))
        await self.await_agent.coroutine(agent)
        if world is not None and world.is_paused:
            await self.link.until(lambda: agent not in world.missing, seconds)
        operation = replace(operation, by=operation.by or self.demonstrator)
        service = getattr(srv, type(operation).__name__)
        request, end, left = request_of(operation), time.monotonic() + seconds, seconds
        while True:
            try:
                return await self.ask.coroutine(
                    agent, service, operation.name, request, seconds=left
                )
            except RequestRefused as error:
                # An agent that was restarted in a training gets its first percept a moment later.
                # Its status on the topic may be newer than its refusal.
                is_blind = isinstance(operation, Command) and not error.answer.status.perceived
                left = end - time.monotonic()
                if not is_blind or left <= 0.0:
                    raise
                if not await self.link.until(lambda: self.statuses[agent].perceived, left):
                    raise

    @blocking
    async def ask(
        self,
        agent: str,
        kind: Any,
        service: str,
        request: Any,
        *,
        seconds: float = ANSWER_S,
    ) -> Any:
        """Call one of an agent's services and return its answer.

        Raises:
            SwarmError: if the agent refuses, with its message.
        """
        full_name = names.of_agent(agent, service, self.prefix)
        self.link.will_call(kind, full_name)  # a host creates it together with the status
        await self.await_agent.coroutine(agent)
        try:
            return await self.link.call.coroutine(
                kind,
                full_name,
                request,
                missing=lambda: self._absence(agent, DISCOVERY_S),
                where=agent,
                seconds=seconds,
                over=lambda: self.is_lost(agent),
                heard=lambda answer: self._take_answer(agent, answer),
            )
        except RequestRefused:
            raise  # so its process is there
        except SwarmError as error:
            raise self.reason(agent) or error from None

    def will_do(self, agent: str, kind: type[Operation]) -> None:
        """Prepare for an operation, so that its service is discovered before it is needed."""
        service = names.of_agent(agent, kind.name, self.prefix)
        self.link.will_call(getattr(srv, kind.__name__), service)

    def _take_answer(self, agent: str, answer: Any) -> None:
        """Take the status in an answer, which may be newer than that on the topic."""
        status = getattr(answer, "status", None)
        if status is not None and status.agent:
            self._take_status(agent, status)

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
        await turn(0.0)  # for statuses that arrived while this client was not spinning

        def has_come() -> bool:
            self.watch_training(agent)
            wanted, training = self.statuses[agent].training.revision, self.trainings.get(agent)
            if not wanted or training is None:
                return not wanted
            return training.revision >= wanted and (training.searched or not searched)

        if not await self.link.until(
            has_come, ANSWER_S, 0.01, lambda: f"what {agent} is being trained"
        ):
            raise self.reason(agent) or SwarmError(
                "it does not publish its training", Fix.LOGS(node=agent), where=agent
            )
        if not self.statuses[agent].training.revision:
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
    async def behavior(self, agent: str, name: str = "", **fields: Any) -> Learned:
        """Return a learned behavior, or a preview of one; see GetBehavior.srv."""
        from hitab_client.learned import learned_of  # deferred: loads the learning code

        request = GetBehavior.Request(name=name, **fields)
        return learned_of(
            await self.ask.coroutine(agent, GetBehavior, names.GET_BEHAVIOR, request)
        )

    @blocking
    async def report(self, agent: str, automaton: str = "") -> list[TrainingCost]:
        """Return the costs of trainings, oldest first; see GetReport.srv."""
        from hitab_core.assistant import TrainingCost  # deferred: loads the learning code

        request = GetReport.Request(automaton=automaton)
        report = await self.ask.coroutine(agent, GetReport, names.GET_REPORT, request)
        return [from_dict(TrainingCost, cost) for cost in report.costs]

    def reload(self, agents: Sequence[str]) -> Iterator[tuple[str, str, bool]]:
        """Make agents reload their libraries; yield the answers, see `reloading`."""
        return map(self.link.run, self.reloading(agents))

    def reloading(self, agents: Sequence[str]) -> Iterator[Turns[tuple[str, str, bool]]]:
        """Yield coroutines that make agents reload their libraries, to be awaited in turn.

        Each returns the name of an agent, its answer, and whether it succeeded. A host whose
        agents are all meant is asked once, and named instead of them.
        """
        within = self.processes.hosts_within({*agents})
        hosts = {host: members for members in within if (host := self.host_of(members[0]))}
        for host in hosts:
            self.link.will_call(srv.LoadLibrary, self._loading(host))
        for host, members in hosts.items():
            yield self._answer(host, self._reload_all(host, members[0]))
        hosted = {name for members in hosts.values() for name in members}
        alone = [agent for agent in agents if agent not in hosted]
        for start in range(0, len(alone), SERVICES_PER_BATCH):
            together = alone[start : start + SERVICES_PER_BATCH]
            for agent in together:
                self.will_do(agent, LoadLibrary)
            for agent in together:
                yield self._answer(agent, self.do.coroutine(agent, LoadLibrary()))

    async def _reload_all(self, host: str, member: str) -> Any:
        """Have all agents of a host reload their libraries."""
        return await self.link.call.coroutine(
            srv.LoadLibrary,
            self._loading(host),
            srv.LoadLibrary.Request(by=self.demonstrator),
            missing=lambda: self._absence(member, DISCOVERY_S),
            seconds=ANSWER_S + self.more_seconds,
            over=lambda: self.is_lost(member),
        )

    def _loading(self, host: str) -> str:
        return names.of_agent(host, LoadLibrary.name, self.prefix)

    async def _answer(self, name: str, asked: Turns[Any]) -> tuple[str, str, bool]:
        try:
            return name, (await asked).message, True
        except SwarmError as error:
            return name, error.what, False

    @blocking
    async def vocabulary(self, agent: str) -> Any:
        """Return an agent's behaviors, features and targets."""
        return await self.ask.coroutine(
            agent, GetVocabulary, names.GET_VOCABULARY, GetVocabulary.Request()
        )

    @blocking
    async def read_features(self, agent: str, also: Sequence[str] = (), cycle: int = 0) -> Any:
        """Return values of an agent's features, now or in a cycle; see ReadFeatures.srv."""
        request = ReadFeatures.Request(also=list(also), cycle=cycle)
        return await self.ask.coroutine(agent, ReadFeatures, names.READ_FEATURES, request)

    # -- distributing -----------------------------------------------------------------------

    @blocking
    async def distribute(
        self,
        source: str,
        sent: Distribute,
        *,
        seconds: float = QUIET_SECONDS,
        progress: Callable[[int, int], None] | None = None,
    ) -> DistributionReport:
        """Send a behavior from one agent to others and wait for their answers.

        Args:
            source: name of the agent that has the behavior.
            sent: the operation; without receivers, for all other agents of the source's domain.
            seconds: timeout for each next answer; the total is not limited.
            progress: called with the numbers of answers and of receivers.

        Raises:
            SwarmError: if the source refuses, or a receiver is missing.
        """
        if not sent.receivers:
            await self.await_agents.coroutine()
        for agent in (source, *sent.receivers):
            await self.await_agent.coroutine(agent)
        chosen = [name for name in sent.receivers or self.mates_of(source) if name != source]
        if not chosen:
            raise SwarmError(f"there is no other agent of the domain of {source} to send it to")
        await self.acknowledgements.await_hearing(
            agent for agent in chosen if not self.is_hosted(agent)
        )
        answer = await self.do.coroutine(source, replace(sent, receivers=chosen))
        report = await self.acknowledgements.gather(
            answer.sequence, answer.digest, chosen, seconds, progress
        )
        report.message = answer.message
        return report
