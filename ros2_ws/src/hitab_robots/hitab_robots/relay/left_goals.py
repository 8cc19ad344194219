"""The action goals of an agent, for the relay to cancel when the agent itself cannot."""

from __future__ import annotations

from functools import partial
from typing import Any

from action_msgs.srv import CancelGoal
from diagnostic_msgs.msg import DiagnosticStatus

from hitab_ros import GuardedNode, names, qos


class LeftGoals:
    """The goals of one agent at action servers, as the agent last published them.

    Goals of other clients on the same servers are not touched.

    Attributes:
        closed: whether the agent has died. Then messages are ignored: they come from the agent
            that replaces it.
    """

    def __init__(self, node: GuardedNode) -> None:
        """Begin to listen.

        Args:
            node: a node in the agent's namespace.
        """
        self.closed = False
        self._node = node
        self._goals: dict[tuple[str, str], CancelGoal.Request] = {}
        self._servers: dict[str, Any] = {}
        node.create_subscription(DiagnosticStatus, names.GOALS, self._hear, qos.LATCHED)

    def _hear(self, agent: DiagnosticStatus) -> None:
        if self.closed:
            return
        self._goals = {}
        for goal in agent.values:
            if goal.key not in self._servers:
                self._servers[goal.key] = self._node.create_client(
                    CancelGoal, f"{goal.key}/_action/cancel_goal"
                )
            request = CancelGoal.Request()
            request.goal_info.goal_id.uuid[:] = list(bytes.fromhex(goal.value))
            self._goals[goal.key, goal.value] = request

    def cancel(self) -> None:
        """Ask servers that are ready to cancel the remaining goals; call this repeatedly."""
        for goal in list(self._goals):
            server = self._servers[goal[0]]
            if server.service_is_ready():
                request = self._goals.pop(goal)
                answer = partial(self._answered, goal, request)
                server.call_async(request).add_done_callback(answer)

    def _answered(self, goal: tuple[str, str], request: Any, future: Any) -> None:
        if future.result().return_code == CancelGoal.Response.ERROR_REJECTED:
            self._node.guard.log(f"{goal[0]} refuses to cancel a goal that its agent has left")
            self._goals[goal] = request
