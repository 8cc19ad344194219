"""Offers the behaviors of an agent as one ROS action, for programs such as a behavior tree."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from hitab_msgs.action import Perform
from rclpy.action import ActionServer, CancelResponse
from rclpy.task import Future

from hitab_core import FLAGS, Agent, Fix, Mode, Term, TrainingError
from hitab_ros import GuardedNode, names
from hitab_ros.answering import remedies_for, what_went_wrong
from hitab_ros.messages.checks import check

DONE, FAILED = FLAGS


@dataclass(slots=True)
class _Goal:
    """A goal that is being carried out.

    Attributes:
        handle: the server's handle of the goal.
        term: the performed behavior.
        ended: receives the outcome (empty if the goal was canceled) and a message.
        path: the active states that were published last.
    """

    handle: Any
    term: Term
    ended: Future
    path: list[str] = field(default_factory=list)


class OfferedAction:
    """The server of an agent's action ``perform_until_done``.

    The server accepts every goal, since only a result can carry a reason: a goal that must be
    refused is aborted at once. The agent has one goal at a time; a new goal replaces it.
    """

    def __init__(
        self,
        node: GuardedNode,
        agent: Agent,
        answered: Callable[[Exception | None], None],
        rest: Callable[[], None],
    ) -> None:
        """Offer the action.

        Args:
            node: the agent's node.
            agent: the agent.
            answered: called after a goal was accepted or refused.
            rest: makes the agent perform its commander's order or, without an order, nothing.
        """
        self._node = node
        self._agent = agent
        self._answered = answered
        self._rest = rest
        self._goal: _Goal | None = None
        guard, key = node.guard, f"action {names.PERFORM_UNTIL_DONE}"
        self._server = ActionServer(
            node,
            Perform,
            names.PERFORM_UNTIL_DONE,
            guard.wrap(key, self._carry_out, otherwise=Perform.Result(message="see its log")),
            cancel_callback=guard.wrap(key, self._cancel, otherwise=CancelResponse.REJECT),
        )

    async def _carry_out(self, handle: Any) -> Perform.Result:
        request = handle.request
        try:
            check(request)
            term = Term.parse(request.behavior, request.targets)
            self._check_free()
            self._agent.perform(term)
        except Exception as error:
            handle.abort()
            self._answered(error)
            ways = map(str, remedies_for(error))
            return Perform.Result(message="; ".join((what_went_wrong(error), *ways)))
        self._end(Perform.Result.REPLACED, f'"{term}" was asked for')
        goal = self._goal = _Goal(handle, term, Future(executor=self._node.executor))
        self._answered(None)
        outcome, message = await goal.ended
        if outcome == Perform.Result.DONE:
            handle.succeed()
        elif not outcome and handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        return Perform.Result(outcome=outcome, message=message)

    def _check_free(self) -> None:
        """Check that no demonstrator trains the agent.

        Raises:
            TrainingError: if one does.
        """
        agent = self._agent
        if agent.mode in (Mode.TRAINING, Mode.TESTING):
            raise TrainingError(
                f'it is {agent.mode} "{agent.training}"',
                Fix.SAVE(agent=agent.name),
                Fix.IDLE(agent=agent.name),
            )

    def _cancel(self, handle: Any) -> CancelResponse:
        goal = self._goal
        if goal is None or goal.handle is not handle:
            return CancelResponse.REJECT
        self._end("", "canceled")
        self._rest()
        return CancelResponse.ACCEPT

    def look(self) -> None:
        """End the goal if its behavior has raised a flag or is no longer performed.

        Call this after each tick and each change of what is performed.
        """
        goal = self._goal
        if goal is None:
            return
        agent = self._agent
        raised = agent.raised
        if agent.mode is not Mode.PERFORMING or agent.top != goal.term:
            now = f'{agent.mode} "{agent.behavior}"' if agent.behavior else str(agent.mode)
            self._end(Perform.Result.REPLACED, f"{agent.name} is {now}")
        elif raised:
            flag = FAILED if FAILED in raised else DONE
            outcome = Perform.Result.FAILED if flag == FAILED else Perform.Result.DONE
            self._end(outcome, f'"{goal.term}" raised {flag}')
            self._rest()
        elif agent.active_path != goal.path:
            goal.path = agent.active_path
            goal.handle.publish_feedback(
                Perform.Feedback(active_path=goal.path, cycle=agent.cycle)
            )

    def _end(self, outcome: str, message: str) -> None:
        """End the goal, if there is one."""
        goal, self._goal = self._goal, None
        if goal is not None:
            goal.ended.set_result((outcome, message))

    def close(self) -> None:
        """Destroy the server: the agent is shutting down."""
        self._server.destroy()
