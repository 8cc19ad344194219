"""A goal of a ROS action, from waiting for the server to the result."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from typing import Any
from uuid import uuid4

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action.client import ClientGoalHandle
from unique_identifier_msgs.msg import UUID

from hitab_core import ActionCall
from hitab_ros import Guard

_GOAL_OVER = (CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID, CancelGoal.Response.ERROR_GOAL_TERMINATED)


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of waiting times, s.

    Attributes:
        answer: for a server to appear, to accept a goal, and to end a canceled goal.
        pulse: for the agent's next tick; then its goal is canceled. 0 for no limit.
    """

    answer: float
    pulse: float


@dataclass(eq=False)
class Server:
    """The server of an action, as its client sees it.

    Attributes:
        client: the action's client.
        label: the action's name and type, for error texts.
        limits: how long to wait.
        guard: the guard of the agent's node.
        changed: called after each answer of the server.
        goals: present and future goals of the server.
    """

    client: Any
    label: str
    limits: Limits
    guard: Guard
    changed: Callable[[], None]
    goals: list[Goal] = field(default_factory=list)


class _Stage(Enum):
    ORPHANED = "a process that is gone has sent it, and the server cannot be reached yet"
    WAITING = "for the server, or for it to end the agent's previous goal"
    SENT = "the server has not answered yet"
    RUNNING = "the server has taken it"
    CANCELING = "the server was asked to cancel it"
    ENDED = "the server is done with it, or is given up"


class Goal:
    """Carries out one `ActionCall`.

    Callbacks may come long after the state was left or entered again. Each callback belongs to one
    goal, and a call that is over ignores it.

    Attributes:
        call: the call to carry out.
        runs_on: why the server continues a canceled goal; empty if it does not.
    """

    def __init__(
        self, call: ActionCall, message: Any, server: Server, identity: bytes = b""
    ) -> None:
        """Wait for the server; `look` sends the goal.

        Args:
            call: the call to carry out.
            message: a message of the action's goal type.
            server: the action's server.
            identity: identity of a goal that an earlier process sent, to cancel it; else empty.
        """
        self.call = call
        self.runs_on = ""
        self._message = message
        self._server = server
        self._is_left = call.left
        self._stage = _Stage.ORPHANED if identity else _Stage.WAITING
        self._since = self._heard = self._pulsed = time.monotonic()
        self._pulses = call.pulses
        self._id = UUID(uuid=list(identity or uuid4().bytes))
        self._handle = ClientGoalHandle(server.client, self._id, None)

    @property
    def identity(self) -> bytes:
        """The goal's identity at the server; empty before it is sent and after its end."""
        return b"" if self._stage in (_Stage.WAITING, _Stage.ENDED) else bytes(self._id.uuid)

    @property
    def is_sent(self) -> bool:
        """Whether a server may be carrying out the goal."""
        return bool(self.runs_on) or self._stage not in (_Stage.WAITING, _Stage.ENDED)

    @property
    def is_ended(self) -> bool:
        """Whether the server is done with it, or given up."""
        return self._stage is _Stage.ENDED

    @property
    def keeps_others_waiting(self) -> bool:
        """Whether the server must not get another goal yet."""
        return self._stage not in (_Stage.ORPHANED, _Stage.ENDED)

    def look(self, *, free: bool) -> None:
        """Send the goal once that is possible; fail or give up after too long a wait.

        Args:
            free: whether the server has no previous goal of this agent.
        """
        now = time.monotonic()
        late = now - self._since > self._server.limits.answer
        match self._stage:
            case _Stage.ORPHANED if self._server.client.server_is_ready():
                self._cancel()
                self._await_result()
            case _Stage.WAITING:
                self._look_for_server(now, late, free)
            case _Stage.SENT if late:
                self._give_up(f"did not answer within {self._server.limits.answer:g} s")
            case _Stage.RUNNING:
                self._look_after(now)
            case _Stage.CANCELING if late:
                self.runs_on = f"{self._server.label} did not end a canceled goal; it is given up"
                self._stage = _Stage.ENDED

    def leave(self) -> None:
        """Cancel the goal; if it is not accepted yet, as soon as it is."""
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
        elif self._server.client.server_is_ready():
            self._enter(_Stage.SENT)
            feedback = self._server.guard.wrap(
                f"feedback of {self._server.label}", self._on_feedback
            )
            future = self._server.client.send_goal_async(self._message, feedback, self._id)
            future.add_done_callback(
                self._server.guard.wrap(f"answer of {self._server.label}", self._on_answer)
            )
        elif late:
            self._give_up(
                f"has no server: none appeared within {self._server.limits.answer:g} s; start it, "
                "or correct the name and the type of the action in the domain"
            )

    def _look_after(self, now: float) -> None:
        call, pulse_timeout = self.call, self._server.limits.pulse
        if call.pulses != self._pulses:
            self._pulses, self._pulsed = call.pulses, now
        if not self._server.client.server_is_ready():
            self._give_up("has no server any more: it is gone")
        elif 0.0 < call.behavior.feedback_within < now - self._heard:
            self._fail(f"gave no feedback for {call.behavior.feedback_within:g} s")
            self._cancel()
        elif 0.0 < pulse_timeout < now - self._pulsed:
            self._fail(
                f"lost its goal: the agent has not acted for {pulse_timeout:g} s, so the goal was "
                "canceled; see its other faults, or set its parameter action_patience"
            )
            self._cancel()

    def _on_answer(self, future: Any) -> None:
        self._handle = future.result()
        if not self._handle.accepted:
            self._give_up("rejected the goal")
        else:
            self.call.accepted = True
            if self._stage is _Stage.SENT:
                self._enter(_Stage.RUNNING)
                self._heard = self._pulsed = self._since
            self._await_result()
            if self._is_left or not self.call.is_open:  # meanwhile, or the answer came too late
                self._cancel()
        self._server.changed()

    def _await_result(self) -> None:
        self._handle.get_result_async().add_done_callback(
            self._server.guard.wrap(f"result of {self._server.label}", self._on_result)
        )

    def _on_feedback(self, message: Any) -> None:
        self._heard = time.monotonic()
        if self.call.is_open:
            self.call.feedback = message.feedback

    def _on_result(self, future: Any) -> None:
        answer = future.result()
        match answer.status:
            case GoalStatus.STATUS_SUCCEEDED:
                self.call.succeed()
            case GoalStatus.STATUS_ABORTED:
                self._fail(f"aborted the goal{_details_of(answer.result)}")
            case GoalStatus.STATUS_CANCELED:
                self._fail(f"had the goal canceled by another client{_details_of(answer.result)}")
            case _:
                self._fail("does not know the goal any more; was it restarted?")
        self._end()

    def _cancel(self) -> None:
        self._enter(_Stage.CANCELING)
        self._handle.cancel_goal_async().add_done_callback(
            self._server.guard.wrap(f"canceling {self._server.label}", self._on_canceled)
        )

    def _on_canceled(self, future: Any) -> None:
        answer = future.result()
        if answer.goals_canceling or self._stage is not _Stage.CANCELING:
            return  # the result is still to come, or has come already
        if answer.return_code in _GOAL_OVER:
            self._end()
        else:
            self.runs_on = f"{self._server.label} refuses to cancel a goal, and continues it"
            self._stage = _Stage.ENDED
            self._server.changed()

    def _end(self) -> None:
        self._stage, self.runs_on = _Stage.ENDED, ""
        self._server.changed()

    def _enter(self, stage: _Stage) -> None:
        self._stage, self._since = stage, time.monotonic()

    def _fail(self, why: str) -> None:
        if not self._is_left:
            self.call.fail(f"{self._server.label} {why}")

    def _give_up(self, why: str) -> None:
        self._fail(why)
        self._stage = _Stage.ENDED


def _details_of(result: Any) -> str:
    """Return the texts and error codes of a result, such as a message for people."""
    texts = []
    for name in result.get_fields_and_field_types():
        value = getattr(result, name)
        if value and (isinstance(value, str) or name == "error_code"):
            texts.append(f"{name}: {value}")
    return f" ({'; '.join(texts)})" if texts else ""
