"""One goal of an action at its server, from waiting for the server to the result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal

from hitab_core import ActionCall
from hitab_ros import Guard, GuardedNode

_OVER = (CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID, CancelGoal.Response.ERROR_GOAL_TERMINATED)


@dataclass(frozen=True, slots=True)
class Limits:
    """How long to wait, s.

    Attributes:
        answer: for a server to appear, to take a goal, and to end a canceled one.
        pulse: for the agent to act, before its goal is canceled; 0: for ever.
    """

    answer: float
    pulse: float


class _Stage(Enum):
    WAITING = "for the server, or for it to end the agent's previous goal"
    SENT = "the server has not answered yet"
    RUNNING = "the server has taken it"
    CANCELING = "the server was asked to cancel it"
    ENDED = "the server is done with it, or is given up"


class Goal:
    """Carries out one `ActionCall`.

    Callbacks may come long after the state was left, or entered anew: each belongs to its goal,
    and a call that is over ignores them.
    """

    def __init__(
        self,
        call: ActionCall,
        message: Any,
        client: Any,
        label: str,
        limits: Limits,
        guard: Guard,
        seconds: Callable[[], float],
        changed: Callable[[ActionCall], None],
        freed: Callable[[], None],
        runs_on: Callable[[str], None],
    ) -> None:
        """Wait for the server; `look` sends the goal.

        Args:
            call: to carry out.
            message: of the action's goal type.
            client: of the action.
            label: of the action, for people.
            limits: how long to wait.
            guard: of the agent's node.
            seconds: returns the monotonic time.
            changed: called when the call has failed, or its server has taken the goal.
            freed: called when the server can get the next goal of this agent.
            runs_on: called with the reason when the server does not cancel the goal, and with an
                empty text once it is done with it.
        """
        self.call = call
        self._message = message
        self._client = client
        self._label = label
        self._limits = limits
        self._guard = guard
        self._seconds = seconds
        self._changed = changed
        self._freed = freed
        self._runs_on = runs_on
        self._is_left = False
        self._stage = _Stage.WAITING
        self._since = self._heard = self._pulsed = seconds()
        self._pulses = call.pulses
        self._handle: Any = None

    @property
    def identity(self) -> bytes:
        """What the server knows the goal by; empty: it has not taken it, or is done with it."""
        taken = self._handle is not None and self._handle.accepted and not self.is_ended
        return bytes(self._handle.goal_id.uuid) if taken else b""

    @property
    def is_sent(self) -> bool:
        """Whether a server may carry it out."""
        return self._stage not in (_Stage.WAITING, _Stage.ENDED)

    @property
    def is_ended(self) -> bool:
        """Whether the server may get another goal."""
        return self._stage is _Stage.ENDED

    def look(self, *, free: bool) -> None:
        """Send the goal once that is possible; fail or give up what takes too long.

        Args:
            free: whether the server has no previous goal of this agent.
        """
        now = self._seconds()
        late = now - self._since > self._limits.answer
        match self._stage:
            case _Stage.WAITING:
                self._look_for_server(now, late, free)
            case _Stage.SENT if late:
                self._fail(f"{self._label} did not answer within {self._limits.answer:g} s")
                self._stage = _Stage.ENDED
            case _Stage.RUNNING:
                self._look_after(now)
            case _Stage.CANCELING if late:
                self._runs_on(f"{self._label} did not end a canceled goal; it is given up")
                self._stage = _Stage.ENDED

    def leave(self) -> None:
        """Cancel the goal; once it is accepted, if it is not yet."""
        self._is_left = True
        if self._stage is _Stage.WAITING:
            self._stage = _Stage.ENDED
        elif self._stage is _Stage.RUNNING:
            self._cancel()

    # -- stages -----------------------------------------------------------------------------

    def _look_for_server(self, now: float, late: bool, free: bool) -> None:
        if not self.call.is_open:
            self._stage = _Stage.ENDED
        elif not free:
            self._since = now
        elif self._client.server_is_ready():
            self._enter(_Stage.SENT)
            future = self._client.send_goal_async(
                self._message, self._guard.wrap(f"feedback of {self._label}", self._on_feedback)
            )
            future.add_done_callback(self._guard.wrap(f"answer of {self._label}", self._on_answer))
        elif late:
            self._fail(
                f"no server of {self._label} appeared within {self._limits.answer:g} s; start it, "
                "or correct the name of the action in the domain"
            )
            self._stage = _Stage.ENDED

    def _look_after(self, now: float) -> None:
        call = self.call
        if call.pulses != self._pulses:
            self._pulses, self._pulsed = call.pulses, now
        if not self._client.server_is_ready():
            self._fail(f"the server of {self._label} is gone")
            self._stage = _Stage.ENDED
        elif 0.0 < call.behavior.feedback_within < now - self._heard:
            self._fail(f"{self._label} gave no feedback for {call.behavior.feedback_within:g} s")
            self._cancel()
        elif 0.0 < self._limits.pulse < now - self._pulsed:
            self._fail(
                f"the agent has not acted for {self._limits.pulse:g} s, so the goal was canceled; "
                "see its other faults, or set its parameter action_patience"
            )
            self._cancel()

    def _on_answer(self, future: Any) -> None:
        handle = self._handle = future.result()
        if not handle.accepted:
            self._fail(f"{self._label} rejected the goal")
            self._end()
            return
        self.call.accepted = True
        if self._stage is _Stage.SENT:
            self._enter(_Stage.RUNNING)
            self._heard = self._pulsed = self._since
        handle.get_result_async().add_done_callback(
            self._guard.wrap(f"result of {self._label}", self._on_result)
        )
        if self.call.is_open and not self._is_left:
            self._changed(self.call)
        else:  # it was left meanwhile, or the answer came too late
            self._cancel()

    def _on_feedback(self, message: Any) -> None:
        self._heard = self._seconds()
        if self.call.is_open:
            self.call.feedback = message.feedback

    def _on_result(self, future: Any) -> None:
        answer = future.result()
        status = answer.status
        if status == GoalStatus.STATUS_SUCCEEDED:
            self.call.succeed()
        elif status == GoalStatus.STATUS_ABORTED:
            self._fail(f"{self._label} aborted the goal{_told(answer.result)}")
        elif status == GoalStatus.STATUS_CANCELED:
            self._fail(f"somebody else canceled the goal of {self._label}{_told(answer.result)}")
        else:
            self._fail(f"{self._label} does not know the goal any more; was it restarted?")
        self._runs_on("")
        self._end()

    def _cancel(self) -> None:
        self._enter(_Stage.CANCELING)
        self._handle.cancel_goal_async().add_done_callback(
            self._guard.wrap(f"canceling {self._label}", self._on_canceled)
        )

    def _on_canceled(self, future: Any) -> None:
        answer = future.result()
        if answer.goals_canceling or self._stage is not _Stage.CANCELING:
            return  # the result is still to come, or has come already
        if answer.return_code not in _OVER:
            self._runs_on(f"{self._label} refuses to cancel a goal, and goes on with it")
        self._end()

    def _end(self) -> None:
        self._stage = _Stage.ENDED
        self._freed()

    def _enter(self, stage: _Stage) -> None:
        self._stage, self._since = stage, self._seconds()

    def _fail(self, why: str) -> None:
        if not self._is_left and self.call.fail(why):
            self._changed(self.call)


class OrphanedGoal:
    """A goal of a process that is gone; it is cancelled as soon as its server can be reached."""

    def __init__(
        self, node: GuardedNode, action: str, identity: str, over: Callable[[str], None]
    ) -> None:
        """Begin.

        Args:
            node: of the agent.
            action: name of the action.
            identity: of the goal, as a hexadecimal number.
            over: called with the reason if the server refuses, else with an empty text.
        """
        self.action, self.identity = action, identity
        self._label = node.resolve_service_name(action)
        self._over = over
        self._asked = False
        name = f"{action}/_action/cancel_goal"  # of every server of actions
        self._client = node.create_client(CancelGoal, name)

    def look(self) -> None:
        """Ask the server, once."""
        if not self._asked and self._client.service_is_ready():
            self._asked = True
            request = CancelGoal.Request()
            request.goal_info.goal_id.uuid = list(bytes.fromhex(self.identity))
            self._client.call_async(request).add_done_callback(self._on_canceled)

    def _on_canceled(self, future: Any) -> None:
        answer = future.result()
        refused = not answer.goals_canceling and answer.return_code not in (0, *_OVER)
        what = "refuses to cancel a goal of before the restart, and goes on with it"
        self._over(f"{self._label} {what}" if refused else "")


def _told(result: Any) -> str:
    """Return the texts and error codes of a result, such as a message for people."""
    told = []
    for name in result.get_fields_and_field_types():
        value = getattr(result, name)
        if value and (isinstance(value, str) or (name == "error_code" and value)):
            told.append(f"{name}: {value}")
    return f" ({'; '.join(told)})" if told else ""
