"""The link of an agent without its own robot to a world: percepts in, actions out."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from hitab_msgs import msg

from hitab_agent.order_subscriptions import OrderSubscriptions
from hitab_agent.round_gate import RoundGate
from hitab_ros import GuardedNode, names, qos


class WorldLink:
    """Answers each percept of the world with the agent's action, as fast as it can.

    In lockstep it answers after the agent's commander, if it has one, has given its order for the
    round. For the link to a robot see `hitab_agent.robot_link`.
    """

    def __init__(
        self,
        node: GuardedNode,
        world: str,
        orders: OrderSubscriptions,
        *,
        take_in: Callable[[msg.Percept], bool],
        answer: Callable[[msg.Percept], tuple[Sequence[float], str]],
        awaited_orders: Callable[[], Collection[str]],
    ) -> None:
        """Subscribe to percepts.

        Args:
            node: of the agent.
            world: name of the world.
            orders: receive the orders of commanders.
            take_in: has the agent perceive.
            answer: has it act on what it perceived; returns what it does and says.
            awaited_orders: returns the topics of the orders that it waits for in a lockstep
                round.
        """
        self._gate = RoundGate(orders)
        self._take_in = take_in
        self._answer = answer
        self._awaited_orders = awaited_orders
        # One message is reused for all answers: publishing copies it.
        self._action = msg.Action(agent=names.own_name(node))
        self._actions = node.create_publisher(
            msg.Action, names.in_swarm(node, world, names.ACTIONS), qos.CYCLE
        )
        self._subscription = node.create_subscription(
            msg.Percept, names.PERCEPT, self._on_percept, qos.CYCLE
        )

    def _on_percept(self, percept: msg.Percept) -> None:
        self._take_in(percept)
        awaited = self._awaited_orders() if percept.lockstep else ()
        if awaited:
            self._gate.begin(
                percept.sequence, awaited, lambda: self._act(percept), look=percept.look
            )
        else:
            self._act(percept)

    def _act(self, percept: msg.Percept) -> None:
        action = self._action
        action.values, action.say = self._answer(percept)
        action.sequence = percept.sequence
        self._actions.publish(action)

    def close(self) -> None:
        """Do nothing: the world notices that an agent is gone."""
