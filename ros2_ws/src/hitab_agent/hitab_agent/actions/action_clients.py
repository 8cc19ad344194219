"""Carries out the basic behaviors of an agent that are actions."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from rclpy.action import ActionClient, get_action_names_and_types

from hitab_agent.actions.fields import FieldError, action_type, has_path, is_number, put
from hitab_agent.actions.goal import Goal, Limits, OrphanedGoal
from hitab_agent.line_memory import LineMemory
from hitab_agent.ticker import Ticker
from hitab_core import (
    ActionBehavior,
    ActionCall,
    Agent,
    Domain,
    FeedbackFeature,
    HitabError,
    VocabularyError,
    action_behaviors,
    calls_of,
    unknown,
)
from hitab_ros import GuardedNode

LOOK_PERIOD_S = 0.1
"""How often the goals are looked after, s."""


class ActionClients:
    """Sends and cancels the goals of one agent, never waiting for an answer.

    A server has at most one goal of the agent: while it still cancels one, the next one waits.
    Each failure is a fault of the agent until the server takes another goal of the same behavior,
    or the agent performs something else.
    """

    def __init__(
        self, node: GuardedNode, agent: Agent, ticker: Ticker, limits: Limits, memory: Path
    ) -> None:
        """Create a client for each action.

        Args:
            node: of the agent.
            agent: the agent; its domain was checked with `check_actions`.
            ticker: of its process.
            limits: how long to wait for servers, and for the agent.
            memory: file that names the goals that servers have, for them to be cancelled should
                this process be killed.
        """
        self._node = node
        self._agent = agent
        self._ticker = ticker
        self._limits = limits
        self._clients: dict[tuple[str, str], Any] = {}
        self._goals: dict[tuple[str, str], list[Goal]] = {}
        self._failed_in: dict[str, tuple[str, str]] = {}
        for behavior in action_behaviors(agent.domain):
            key = _key(behavior)
            if key not in self._clients:
                kind = action_type(behavior.action_type)
                self._clients[key] = ActionClient(node, kind, behavior.action)
                self._goals[key] = []
        self._held = False
        self._run_on: set[str] = set()
        self._memory = LineMemory(memory)
        self._orphans = []
        for action, identity in _remembered(self._memory.values):
            over = functools.partial(self._on_orphan, identity)
            self._orphans.append(OrphanedGoal(node, action, identity, over))
        calls_of(agent.body).carrier = self
        ticker.every(LOOK_PERIOD_S, self.look, node.guard)

    # -- for the engine ---------------------------------------------------------------------

    def begin(self, call: ActionCall) -> None:
        """Send the goal of a call, as soon as the server can get it."""
        behavior = call.behavior
        message = action_type(behavior.action_type).Goal()
        try:
            for path, value in call.goal.items():
                put(message, path, value)
        except FieldError as error:
            call.fail(f"the field {error} in the goal of {behavior.action_type}")
            self.failed(call)
            return
        key = _key(behavior)
        goal = Goal(
            call,
            message,
            self._clients[key],
            f"{self._full(behavior)} ({behavior.action_type})",
            self._limits,
            self._node.guard,
            self._ticker.seconds,
            self._changed,
            lambda: self._look_at(key),
            lambda why: self._on_run_on(behavior, why),
        )
        self._goals[key].append(goal)
        self._look_at(key)

    def leave(self, call: ActionCall) -> None:
        """Cancel the goal of a call."""
        for goal in self._goals[_key(call.behavior)]:
            if goal.call is call:
                goal.leave()

    def hold(self, *, held: bool) -> None:
        """Cancel the goals since the robot has to stand still, or send them anew."""
        if held is self._held:
            return  # only the reason has changed
        self._held = held
        for goals in list(self._goals.values()):
            for goal in [goal for goal in goals if held and goal.is_sent and goal.call.is_open]:
                goal.leave()
                self.begin(goal.call)  # it waits
        self.look()

    @property
    def at_rest(self) -> bool:
        """Whether no server carries out a goal of this agent."""
        sent = any(goal.is_sent for goals in self._goals.values() for goal in goals)
        return not (sent or self._orphans or self._run_on)

    def failed(self, call: ActionCall) -> None:
        """Show why a call failed."""
        self._changed(call)

    # -- looking after the goals --------------------------------------------------------------

    def look(self) -> None:
        """Look after all goals; call this a few times a second."""
        for key, goals in self._goals.items():
            if goals:
                self._look_at(key)
        for orphan in self._orphans:
            orphan.look()

    def _on_orphan(self, identity: str, why: str) -> None:
        self._orphans = [orphan for orphan in self._orphans if orphan.identity != identity]
        self._node.guard.faults.set(f"action goal {identity}", why)
        self._remember()

    def _on_run_on(self, behavior: ActionBehavior, why: str) -> None:
        fault = f"action {behavior.name} runs on"
        self._node.guard.faults.set(fault, why)
        self._run_on.discard(fault)
        if why:
            self._node.guard.log(why)
            self._run_on.add(fault)

    def _remember(self) -> None:
        """Note which goals servers have, if that has changed."""
        goals = [(orphan.action, orphan.identity) for orphan in self._orphans]
        for (action, _), those in self._goals.items():
            goals += [(action, goal.identity.hex()) for goal in those if goal.identity]
        if [*map(tuple, _remembered(self._memory.values))] != goals:
            try:
                self._memory.write({"goals": goals})
            except OSError as error:
                self._node.guard.log(f"a restart would not cancel the goals of actions: {error}")

    def _look_at(self, key: tuple[str, str]) -> None:
        free = not self._held
        for goal in list(self._goals[key]):
            goal.look(free=free)
            free = free and goal.is_ended
        self._goals[key] = [goal for goal in self._goals[key] if not goal.is_ended]
        self._remember()

    def _changed(self, call: ActionCall) -> None:
        """Show a failure as a fault, or clear that of an earlier call."""
        fault = _fault(call.behavior)
        agent = self._agent
        if call.why and not call.left:
            why = call.why + self._of_other_type(call.behavior)
            text = f'{agent.name}: "{call.use}" failed: {why}'
            self._node.guard.log(text)
            self._node.guard.faults.set(fault, text)
            self._failed_in[fault] = (agent.mode.value, agent.behavior)
        elif call.is_open and fault in self._failed_in:
            del self._failed_in[fault]
            self._node.guard.faults.clear(fault)
        self._remember()

    def _of_other_type(self, behavior: ActionBehavior) -> str:
        """Return that there is an action of this name and another type, if that is so."""
        client = self._clients[_key(behavior)]
        if client.server_is_ready():
            return ""
        full = self._full(behavior)
        for name, types in get_action_names_and_types(self._node):
            others = sorted({*types} - {behavior.action_type})
            if name == full and others:
                return f"; there is one of that name, but its type is {', '.join(others)}"
        return ""

    def _full(self, behavior: ActionBehavior) -> str:
        return str(self._node.resolve_service_name(behavior.action))

    def clear_if_past(self) -> None:
        """Clear the faults of what the agent no longer performs."""
        agent = self._agent
        now = (agent.mode.value, agent.behavior)
        for fault in [one for one, then in self._failed_in.items() if then != now]:
            del self._failed_in[fault]
            self._node.guard.faults.clear(fault)

    def close(self) -> None:
        """Cancel all goals and destroy the clients: the agent is shutting down."""
        calls_of(self._agent.body).carrier = None
        for goals in self._goals.values():
            for goal in goals:
                goal.leave()
        for client in self._clients.values():
            client.destroy()
        self._clients.clear()
        self._goals.clear()
        self._remember()


def _remembered(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return action and identity of each remembered goal; what is damaged is left out."""
    found = []
    for goal in values.get("goals", []):
        with suppress(TypeError, ValueError):
            action, identity = goal
            if len(bytes.fromhex(identity)) == 16 and isinstance(action, str):
                found.append((action, identity))
    return found


def _key(behavior: ActionBehavior) -> tuple[str, str]:
    return behavior.action, behavior.action_type


def _fault(behavior: ActionBehavior) -> str:
    return f"action {behavior.name}"


def check_actions(domain: Domain) -> None:
    """Check the types, names and fields of a domain's actions and of their feedback.

    Raises:
        HitabError: naming the domain, the behavior or feature, and the field, for all that is
            wrong.
    """
    wrong = []
    behaviors = {behavior.name: behavior for behavior in action_behaviors(domain)}
    for behavior in behaviors.values():
        try:
            _check_behavior(behavior)
        except HitabError as error:
            wrong.append(f'behavior "{behavior.name}": {error}')
    for feature in domain.features.values():
        if isinstance(feature, FeedbackFeature):
            try:
                _check_feedback(feature, behaviors)
            except HitabError as error:
                wrong.append(f'feature "{feature.name}": {error}')
    if wrong:
        raise HitabError(f'domain "{domain.name}": {"; ".join(wrong)}')


def _check_behavior(behavior: ActionBehavior) -> None:
    kind = action_type(behavior.action_type)
    if not behavior.action:
        raise HitabError('it has no action; give its name, such as action="navigate_to_pose"')
    message = kind.Goal()
    try:
        for path, value in behavior.goal.items():
            if callable(value):
                has_path(kind.Goal, path)
            else:
                put(message, path, value)
    except FieldError as error:
        raise HitabError(f"{error}, in the goal of {behavior.action_type}") from None


def _check_feedback(feature: FeedbackFeature, behaviors: dict[str, ActionBehavior]) -> None:
    if feature.behavior not in behaviors:
        raise VocabularyError(unknown("action behavior", feature.behavior, behaviors))
    name = behaviors[feature.behavior].action_type
    try:
        kind = action_type(name)
    except HitabError:
        return  # said of the behavior
    try:
        slot = has_path(kind.Feedback, feature.path)
    except FieldError as error:
        raise HitabError(f"{error}, in the feedback of {name}") from None
    if not (feature.converts or is_number(slot)):
        raise HitabError(
            f'"{feature.path}" in the feedback of {name} is not a number; give value=, a function '
            "that makes one of it"
        )
