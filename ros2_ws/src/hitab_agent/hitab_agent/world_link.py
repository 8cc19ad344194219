"""How an agent without a robot of its own is joined to a world: percepts in, actions out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hitab_msgs import msg

from hitab_agent.round_gate import RoundGate
from hitab_ros import names, qos

if TYPE_CHECKING:
    from hitab_agent.agent_node import AgentNode


class WorldLink:
    """Answers each percept of the world with the agent's action, as fast as it can.

    In lockstep it answers when the agent's commander, if it has one, has given its order of the
    round. A robot's own link is described in `hitab_agent.robot_link`.
    """

    def __init__(self, node: AgentNode, world: str) -> None:
        self._node = node
        self._gate = RoundGate(node.shared.orders)
        # One message is used again for all answers: publishing copies it.
        self._action = msg.Action(agent=node.agent_name)
        self._actions = node.create_publisher(
            msg.Action, names.in_swarm(node, world, names.ACTIONS), qos.CYCLE
        )
        self._subscription = node.create_subscription(
            msg.Percept, names.PERCEPT, self._on_percept, qos.CYCLE
        )

    def _on_percept(self, percept: msg.Percept) -> None:
        node = self._node
        node.take_in(percept)
        if percept.lockstep and node.superior is not None:
            commanders = (node.superior.orders,)
            self._gate.begin(percept.sequence, commanders, lambda: self._answer(percept))
        else:
            self._answer(percept)

    def _answer(self, percept: msg.Percept) -> None:
        action = self._action
        action.values, action.say = self._node.answer(percept)
        action.sequence = percept.sequence
        self._actions.publish(action)

    def close(self) -> None:
        """Do nothing: a world notices by itself that an agent is gone."""
