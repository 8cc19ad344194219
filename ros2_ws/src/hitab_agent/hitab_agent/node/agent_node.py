"""The ROS node of one agent: topics and services around `hitab_core.agent.Agent`."""

from __future__ import annotations

from array import array
from collections.abc import Collection, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from hitab_msgs import msg

from hitab_agent import actions
from hitab_agent.agent_endpoints import AgentEndpoints
from hitab_agent.host_resources import HostResources
from hitab_agent.links.robot_link import OwnStop, link_class
from hitab_agent.links.superior_link import SuperiorLink
from hitab_agent.links.world_link import WorldLink
from hitab_agent.node.agent_base import AgentBase
from hitab_agent.node.diagnosis import diagnosis_of_agent
from hitab_agent.node.guarded_tick import NO_ACTION, Action, GuardedTick
from hitab_agent.node.restart_memory import RestartMemory
from hitab_agent.node.settings import AgentParameters
from hitab_agent.topics.percept_log import PerceptLog
from hitab_agent.topics.status_publisher import StatusPublisher
from hitab_agent.topics.training_topic import TrainingTopic
from hitab_agent.topics.transition_log import TransitionLog
from hitab_core import (
    RESERVED_NAMES,
    Agent,
    Domain,
    Fix,
    HitabError,
    LostBehaviorError,
    Mode,
    Term,
    action_behaviors,
    quantity,
    uses_actions,
)
from hitab_core.operations import Command
from hitab_core.orders import Subordinate
from hitab_core.training.operation import Operation, Outcome
from hitab_ros import names
from hitab_ros.messages.stamps import seconds_of
from hitab_ros.nodes.diagnostics import Diagnosis


class AgentNode(AgentBase):
    """One agent of the swarm, in the namespace of its name."""

    def __init__(
        self,
        node_name: str = "agent",
        *,
        shared: HostResources | None = None,
        **options: Any,
    ) -> None:
        """Create the node, load the library and resume an interrupted training.

        Args:
            node_name: name of the node in the agent's namespace.
            shared: resources of all agents of the process; None if this agent is alone.
            options: passed on to the base class.

        Raises:
            HitabError: if the domain, the library or the journal is unusable.
        """
        self._joined = False
        # These would cost each agent of a host three endpoints and more.
        alone = {"enable_rosout": shared is None, "publish_parameter_events": shared is None}
        super().__init__(node_name, **{**alone, **options})
        self.settings = settings = AgentParameters.declare(self)
        self.agent_name = names.own_name(self)
        self.shared = shared or HostResources(self, on_demand=settings.services_on_demand)
        self.scheduler = self.shared.scheduler
        domain = self.load_domain(settings.domain)
        if uses_actions(domain):
            actions.check_actions(domain)
        self.transition_log = TransitionLog(self, logs=shared is None)
        states = Path(settings.state_dir).expanduser()
        state = states / self.agent_name
        library = Path(settings.library).expanduser() if settings.library else state / "library"
        self.agent = Agent(
            self.agent_name,
            domain,
            self.shared.library(library, domain),
            state,
            seed=settings.seed,
            most_probable=settings.most_probable,
            observe=self.guard.wrap("publishing a transition", self.transition_log.observe),
        )
        self.agent.open_library = self.shared.library
        self.agent.send = partial(self.shared.distributions.send, self.agent_name)
        self.percept_log = PerceptLog(self)
        self._tick = GuardedTick(self.agent, self.guard)
        self.status = StatusPublisher(
            self, self.agent, settings, self.shared, self.transition_log, self._prepare_status
        )
        self.training = TrainingTopic(self, self.agent, self.scheduler)
        self.endpoints = AgentEndpoints(self)
        if shared is None:
            self.status.topic.open()  # others that start with this name have to see it
        self._sensed = False
        self._values: Sequence[float] = ()
        self._seconds = 0.0
        self._unsettled = True
        self._link: Any = None
        self.actions: actions.ActionClients | None = None
        self._offered: actions.OfferedAction | None = None
        self.superior: SuperiorLink | None = None
        self._start_error = ""
        self.memory = RestartMemory(states, self.agent_name, settings.swarm)
        if self.memory.damage:
            self.get_logger().warning(self.memory.damage)
        performed, training = self.memory.performed, self.agent.session is not None
        if not (training and self.memory.trained):
            if training:
                self.agent.perform(None)  # the training is kept, as before
            self._begin(settings.behavior if performed is None else performed)

    def remember(self) -> None:
        """Store the performed behavior for a restart, if it has changed."""
        self.guard.run("storing the behavior for a restart", self.memory.keep, self.resumed())

    def resumed(self) -> dict[str, Any]:
        """Return what is stored for a restart: what to resume."""
        agent = self.agent
        performed = agent.top if agent.mode is Mode.PERFORMING else agent.pending_behavior
        trained = agent.mode in (Mode.TRAINING, Mode.TESTING)
        return {"behavior": str(performed or ""), "trained": trained}

    def _begin(self, behavior: str) -> None:
        """Perform a behavior at startup; stay idle if there is none or it cannot be performed.

        The library may have changed in the meantime, and only an agent that is up can be mended.
        """
        if not behavior:
            return
        term = None
        try:
            term = Term.parse(behavior)
            self.agent.perform(term)
        except HitabError as error:
            if isinstance(error, LostBehaviorError):
                self.agent.pending_behavior = term
            self._start_error = (
                f'{self.agent_name} is idle: it cannot perform its start behavior "{behavior}": '
                f"{error.problem}; have it perform something else, or give it the behavior"
            )

    def load_domain(self, name: str) -> Domain:
        """Return the domain that the parameter ``domain`` names."""
        return self.shared.domain(name)

    def join(self) -> None:
        """Start to listen and answer; call this once the name is known to be free."""
        settings, shared = self.settings, self.shared
        self._joined = True
        self.training.searched = self.status.publish_soon
        shared.nodes.append(self)
        self._join_actions()
        self._join_link()
        self.endpoints.offer()
        if settings.commander:
            subordinate = Subordinate(self.agent, settings.role)
            self.superior = self.status.superior = SuperiorLink(self, subordinate)
            self.stop_changed()
        if settings.when_out_of_reach == "halt":
            shared.reach.join(self)
        training, performed = self.agent.session, self.memory.performed
        if training is not None and self.agent.mode is Mode.TRAINING:
            self.status.began(
                note=f'resumed the interrupted training of "{training.curriculum.name}" '
                f"with {quantity(len(training.log), 'example')}"
            )
        elif self._start_error or performed is None:
            self.status.began(fault=self._start_error)
        else:
            again = f'performs "{performed}" again, as before' if performed else "is idle again"
            self.status.began(note=f"was restarted; it {again}")

    def _join_link(self) -> None:
        """Connect the agent to the world, or to its own robot."""
        settings = self.settings
        if self.agent.domain.link:
            link = link_class(self.agent.domain)
            self._link = link(self, settings.world, self._on_percept)
            if self.stop is None and self.has_robot:
                self.stop = OwnStop(self, rearms=settings.auto_rearm)
            self.stop_changed()
        elif self.shared.host is not None:
            self.shared.link(self.shared.host, settings.world)
        else:
            self._link = WorldLink(self, settings.world)

    def _join_actions(self) -> None:
        """Create clients for behaviors that are actions, and offer the agent's own action."""
        settings = self.settings
        if action_behaviors(self.agent.domain):
            limits = actions.Limits(settings.action_timeout, settings.action_patience)
            self.actions = actions.ActionClients(
                self, self.agent, self.scheduler, limits, self.memory
            )
        if settings.offer_actions:
            self._offered = actions.OfferedAction(
                self, self.agent, self.status.report_error, self._obey_or_rest
            )

    def _obey_or_rest(self) -> None:
        """Perform the commander's order; without an order, nothing."""
        self.agent.perform(None)
        if self.superior is not None:
            self.superior.obey_again()
        self.settle()
        self.status.publish_soon()

    def farewell(self) -> None:
        """Cancel the agent's actions, and stop its robot by the link.

        The executor must not spin afterwards: it fails at events of destroyed action clients.
        """
        if self.actions is not None:
            self.actions.close()
        if self._offered is not None:
            self._offered.close()
        self.actions = self._offered = None
        if self._link is not None:
            self._link.close()
            self._link = None

    # -- percepts and commands ----------------------------------------------------------------

    def _on_percept(self, percept: msg.Percept) -> Action:
        self.take_in(percept, seconds_of(percept.stamp))
        return self.answer(percept)

    def take_in(self, percept: msg.Percept, seconds: float) -> None:
        """Take in a percept."""
        log, agent = self.transition_log, self.agent
        if self.percept_log.is_on:
            self.percept_log.tell(percept)
        log.cycle = percept.cycle
        log.stamp = percept.stamp
        self._sensed = False
        self._seconds = seconds
        try:
            if percept.back:
                agent.go_back(percept.cycle)
                if self.superior is not None:
                    self.superior.subordinate.went_back()
            agent.sense(
                percept.values,
                percept.heard,
                percept.cycle,
                seconds,
                jumped=self._is_changed(percept),
            )
            self._values = percept.values
            if percept.restart:
                agent.restart(percept.seed, percept.episode)
            self._sensed = True
            self._tick.perceived()
        except Exception as error:
            self._tick.fail(error)
        if percept.lockstep and self.superior is not None:
            self.superior.round_begins(percept, seconds)

    def _is_changed(self, percept: msg.Percept) -> bool:
        """Whether something was changed meanwhile: a paused world shows its cycle again.

        It also does so when it has just paused, with the same values as before.
        """
        if not percept.look or percept.cycle != self.agent.cycle:
            return False
        return array("d", percept.values).tobytes() != array("d", self._values).tobytes()

    def answer(self, percept: msg.Percept) -> Action:
        """Act on the last percept, unless it is for inspection only."""
        action, agent, status = NO_ACTION, self.agent, self.status.message
        self.hold = ""
        if self._sensed and not percept.look and not self.unreached:
            action, self.hold = self._tick.act(), agent.held
        elif self._sensed and (percept.restart or agent.active_path != self.status.path):
            self.status.publish()
        if self.stop is not None:
            self.stop.cause(self._tick.fault or self.unreached)
            if self.stop.why:
                action = NO_ACTION
        if self._sensed and not status.perceived:
            self.status.publish_soon()
        if agent.monitor.unsure != status.caution.unsure:
            self.status.publish_soon()
            self.shared.diagnostics.soon()
        if agent.held != status.held:
            self.status.publish_soon()
        log = self.transition_log
        changed = self._unsettled or log.changed
        if changed:
            path = agent.active_path
            # The agent leaves a flag state without a transition.
            self._unsettled = bool(path) and path[-1] in RESERVED_NAMES
            log.changed = False
            if path != self.status.path and not percept.look:
                self.status.publish_soon()
        if self._offered is not None:
            self._offered.look()
        if self.superior is not None and not percept.lockstep:
            self.superior.perceived(percept, self._seconds, changed=changed or percept.restart)
        return action

    # -- stop of its robot --------------------------------------------------------------------

    def stop_changed(self) -> None:
        """Publish why the robot may not act; cancel the agent's goals, or resume them."""
        why = self.stop.why if self.stop is not None else ""
        self.agent.stopped = self.status.message.stopped = why
        self.status.message.armed = not why
        ways = [Fix.GO()] if self.stop is not None and self.stop.is_emergency else []
        self.guard.faults.set("stop", why, *ways, Fix.ARM(robot=self.agent_name))
        if self.superior is not None:
            self.superior.subordinate.stopped = bool(why)
            self.superior.tell()
        if self.actions is not None:
            self.actions.hold(held=bool(why))

    def stands(self) -> bool:
        """Whether no action is under way for the agent."""
        return self.actions is None or self.actions.at_rest

    # -- orders of a commander ----------------------------------------------------------------

    def awaited_orders(self) -> Collection[str]:
        """Return the commanders whose orders a lockstep round waits for."""
        return () if self.superior is None else (self.superior.commander,)

    def ordered(self) -> None:
        """Publish the outcome of an order: obeyed, or waiting with the reason."""
        if refusal := self.status.refusal:
            self.guard.log(refusal)
            self.status.report_error(None)
        else:
            self.status.publish_soon()

    def settle(self) -> None:
        """Retry a waiting order after a demonstrator has changed something."""
        if self.superior is not None:
            self.superior.settle()

    # -- status -----------------------------------------------------------------------------

    def do(self, operation: Operation) -> Outcome:
        """Carry out an operation, and publish what became of it."""
        if isinstance(operation, Command):
            self.status.commanded(operation.by)
        try:
            outcome = self.agent.do(operation)
        except Exception as error:
            self.answered(error)
            raise
        self.answered(None)
        return outcome

    def answered(self, error: Exception | None) -> None:
        """Settle after an operation, and show in the status what went wrong."""
        self.settle()
        self.status.report_error(error)

    def faults_changed(self) -> None:
        """Publish a status soon, if the agent has joined."""
        if self._joined:
            self.status.publish_soon()
            self.shared.diagnostics.soon()

    def diagnose(self) -> Diagnosis:
        """Return the faults of the agent."""
        return diagnosis_of_agent(self)

    def _prepare_status(self) -> None:
        self.remember()
        self.status.message.training.revision = self.training.notice()
        self._tick.clear_if_past()
        if self.actions is not None:
            self.actions.clear_if_past()
        if self._offered is not None:
            self._offered.look()
