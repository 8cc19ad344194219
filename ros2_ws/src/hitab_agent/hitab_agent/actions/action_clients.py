"""Action clients: they carry out those basic behaviors of an agent that are ROS actions."""

from __future__ import annotations

from contextlib import suppress
from functools import partial

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.action import ActionClient

from hitab_agent.actions.fields import FieldError, action_type, is_number, put, slot_of
from hitab_agent.actions.goal import Goal, Limits, Server
from hitab_agent.node.restart_memory import RestartMemory
from hitab_agent.scheduler import Scheduler
from hitab_core import (
    ActionBehavior,
    ActionCall,
    Agent,
    Domain,
    FeedbackFeature,
    HitabError,
    Term,
    VocabularyError,
    action_behaviors,
    calls_of,
    unknown,
)
from hitab_ros import GuardedNode, names, qos
from hitab_ros.timing import UPDATE_S


class ActionClients:
    """Sends and cancels the goals of one agent, never waiting for an answer.

    A server has at most one goal of the agent: the next goal waits until the server has ended the
    canceled one. Each failure is a fault of the agent until the server accepts another goal of the
    same behavior, or the agent performs something else.
    """

    def __init__(
        self,
        node: GuardedNode,
        agent: Agent,
        scheduler: Scheduler,
        limits: Limits,
        memory: RestartMemory,
    ) -> None:
        """Create a client for each action.

        Args:
            node: the agent's node.
            agent: the agent; its domain was checked with `check_actions`.
            scheduler: the scheduler of the agent's process.
            limits: how long to wait for servers, and for the agent.
            memory: stores the identities of sent goals. If this process is killed, the next one
                reads them and cancels the goals.
        """
        self._node = node
        self._agent = agent
        self._memory = memory
        self._servers: dict[tuple[str, str], Server] = {}
        self._failed_in: dict[str, tuple[str, ...]] = {}
        self._held = False
        self._published: list[KeyValue] = []
        self._publisher = node.create_publisher(DiagnosticStatus, names.GOALS, qos.LATCHED)
        for behavior in action_behaviors(agent.domain):
            key = _key(behavior)
            if key in self._servers:
                continue
            kind = action_type(behavior.action_type)
            label = f"{node.resolve_service_name(behavior.action)} ({behavior.action_type})"
            client = ActionClient(node, kind, behavior.action)
            changed = partial(self._look_at, key)
            server = self._servers[key] = Server(client, label, limits, node.guard, changed)
            orphaned = ActionCall(behavior, Term(behavior.name), {}, left=True)
            remembered = self._remembered(behavior.action)
            server.goals += [Goal(orphaned, None, server, one) for one in remembered]
        calls_of(agent.body).carrier = self
        scheduler.every(UPDATE_S, self.look, node.guard)

    def _remembered(self, action: str) -> list[bytes]:
        """Return the identities of a killed process's goals, except damaged ones."""
        found = []
        for goal in self._memory.values.get("goals", []):
            with suppress(TypeError, ValueError):
                name, identity = goal
                found += [bytes.fromhex(identity)] if name == action else []
        return [identity for identity in found if len(identity) == 16]

    # -- for the engine ---------------------------------------------------------------------

    def begin(self, call: ActionCall) -> None:
        """Send the goal of a call as soon as its server can take it."""
        behavior = call.behavior
        message = action_type(behavior.action_type).Goal()
        try:
            for path, value in call.goal.items():
                put(message, path, value)
        except FieldError as error:
            call.fail(f"the field {error} in the goal of {behavior.action_type}")
            self.failed(call)
            return
        server = self._servers[_key(behavior)]
        server.goals.append(Goal(call, message, server))
        server.changed()

    def leave(self, call: ActionCall) -> None:
        """Cancel the goal of a call."""
        for goal in self._servers[_key(call.behavior)].goals:
            if goal.call is call:
                goal.leave()

    def failed(self, call: ActionCall) -> None:
        """Show a failure as a fault, or clear the fault of an earlier call."""
        fault, faults = f"action {call.behavior.name}", self._node.guard.faults
        if call.why and not call.left:
            text = f'{self._agent.name}: "{call.term}" failed: {call.why}'
            if faults.text(fault) != text:
                self._node.guard.log(text)
                faults.set(fault, text)
                self._failed_in[fault] = self._doing
        elif call.accepted and call.is_open and self._failed_in.pop(fault, ()):
            faults.clear(fault)

    def hold(self, *, held: bool) -> None:
        """Cancel the goals while the robot has to stand still (``held``), then send them again."""
        if held is self._held:
            return  # only the reason has changed
        self._held = held
        for goal in self._goals if held else ():
            if goal.is_sent and goal.call.is_open:
                goal.leave()
                self.begin(goal.call)  # the new goal waits until the robot may act
        self.look()

    @property
    def at_rest(self) -> bool:
        """Whether no server is carrying out a goal of this agent."""
        return not any(goal.is_sent for goal in self._goals)

    # -- checking the goals -------------------------------------------------------------------

    def look(self) -> None:
        """Check all goals; call this a few times a second."""
        for key, server in self._servers.items():
            if server.goals:
                self._look_at(key)

    def _look_at(self, key: tuple[str, str]) -> None:
        free, guard = not self._held, self._node.guard
        running_on: dict[str, str] = {}
        server = self._servers.get(key)
        if server is None:
            return  # closed
        for goal in list(server.goals):
            goal.look(free=free)
            free = free and not goal.keeps_others_waiting
            self.failed(goal.call)
            name = goal.call.behavior.name
            running_on[name] = running_on.get(name) or goal.runs_on
        for name, why in running_on.items():
            guard.faults.set(f"action {name} runs on", why)
            if why:
                guard.log(why)
        server.goals = [goal for goal in server.goals if goal.runs_on or not goal.is_ended]
        self._remember()

    @property
    def _goals(self) -> list[Goal]:
        return [goal for server in self._servers.values() for goal in server.goals]

    def _remember(self) -> None:
        """Store the sent goals for a restart, and publish them to the robot's relay."""
        goals = [[g.call.behavior.action, g.identity.hex()] for g in self._goals if g.identity]
        stored = {"goals": goals}
        self._node.guard.run("storing goals for a restart", self._memory.keep, stored)
        values = [KeyValue(key=self._node.resolve_service_name(a), value=i) for a, i in goals]
        if values != self._published:
            self._published = values
            self._publisher.publish(DiagnosticStatus(name=self._agent.name, values=values))

    @property
    def _doing(self) -> tuple[str, ...]:
        return self._agent.mode.value, self._agent.behavior

    def clear_if_past(self) -> None:
        """Clear the faults of behaviors that the agent no longer performs."""
        for fault in [one for one, then in self._failed_in.items() if then != self._doing]:
            del self._failed_in[fault]
            self._node.guard.faults.clear(fault)

    def close(self) -> None:
        """Cancel all goals and destroy the clients: the agent is shutting down."""
        calls_of(self._agent.body).carrier = None
        for goal in self._goals:
            goal.leave()
        for server in self._servers.values():
            server.client.destroy()
        self._servers.clear()
        self._remember()


def _key(behavior: ActionBehavior) -> tuple[str, str]:
    return behavior.action, behavior.action_type


def check_actions(domain: Domain) -> None:
    """Check the types, names and fields of a domain's actions and of their feedback.

    Raises:
        HitabError: naming the domain and, for each error, the behavior or feature and the field.
    """
    behaviors = {behavior.name: behavior for behavior in action_behaviors(domain)}
    wrong = []
    for behavior in behaviors.values():
        try:
            _check_behavior(behavior)
        except HitabError as error:
            wrong.append(f'behavior "{behavior.name}": {error}')
    for feature in domain.features.values():
        try:
            if isinstance(feature, FeedbackFeature):
                _check_feedback(feature, behaviors)
        except HitabError as error:
            wrong.append(f'feature "{feature.name}": {error}')
    if wrong:
        raise HitabError(f'domain "{domain.name}": {"; ".join(wrong)}')


def _check_behavior(behavior: ActionBehavior) -> None:
    kind = action_type(behavior.action_type)
    if not behavior.action:
        raise HitabError('it has no action; give its name, such as action="navigate_to_pose"')
    try:
        for path, value in behavior.goal.items():
            if callable(value):
                slot_of(kind.Goal, path)
            else:
                put(kind.Goal(), path, value)
    except FieldError as error:
        raise HitabError(f"{error}, in the goal of {behavior.action_type}") from None


def _check_feedback(feature: FeedbackFeature, behaviors: dict[str, ActionBehavior]) -> None:
    if feature.behavior not in behaviors:
        raise VocabularyError(unknown("action behavior", feature.behavior, behaviors))
    name = behaviors[feature.behavior].action_type
    try:
        slot = slot_of(action_type(name).Feedback, feature.path)
    except FieldError as error:
        raise HitabError(f"{error}, in the feedback of {name}") from None
    if not (feature.converts or is_number(slot)):
        raise HitabError(
            f'"{feature.path}" in the feedback of {name} is not a number; give value=, a function '
            "that makes one of it"
        )
