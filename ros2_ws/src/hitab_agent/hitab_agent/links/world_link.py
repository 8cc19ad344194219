"""The link of an agent without its own robot to a world: percepts in, actions out."""

from __future__ import annotations

from hitab_msgs import msg

from hitab_agent.links.round_gate import RoundGate
from hitab_agent.node.agent_base import AgentBase
from hitab_ros import names, qos
from hitab_ros.messages.cycle_codec import action_bytes, read_percept
from hitab_ros.messages.stamps import seconds_of


class WorldLink:
    """Answers each percept of the world with the agent's action, as fast as it can.

    In lockstep, the answer waits until the agent's commander, if it has one, has given its order
    for the round. For the link to a robot see `hitab_agent.links.robot_link`.
    """

    def __init__(self, node: AgentBase, world: str) -> None:
        """Subscribe to percepts.

        Args:
            node: the agent's node.
            world: name of the world.
        """
        self._node = node
        self._gate = RoundGate(node.shared.exchange)
        # Discovery announces the two in this order, and the world looks for those that answer.
        node.create_subscription(
            msg.Percept, names.PERCEPT, self._on_percept, qos.CYCLE, read=read_percept
        )
        self._actions = node.create_publisher(
            msg.Action, names.in_swarm(node, world, names.ACTIONS), qos.CYCLE
        )

    def _on_percept(self, percept: msg.Percept) -> None:
        self._node.take_in(percept, seconds_of(percept.stamp))
        awaited = self._node.awaited_orders() if percept.lockstep else ()
        self._gate.begin(percept.sequence, awaited, lambda: self._act(percept), look=percept.look)

    def _act(self, percept: msg.Percept) -> None:
        node = self._node
        values, say = node.answer(percept)
        self._actions.publish(
            action_bytes(node.agent_name, percept.sequence, values, say, node.taught, node.hold)
        )

    def close(self) -> None:
        """Do nothing: the world notices that an agent is gone."""
