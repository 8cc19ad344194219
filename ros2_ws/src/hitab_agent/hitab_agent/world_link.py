"""How an agent without a robot of its own is joined to a world: percepts in, actions out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from hitab_msgs import msg
from rclpy.node import Node

from hitab_ros import names, qos

OnPercept = Callable[[msg.Percept], tuple[Sequence[float], str]]


class WorldLink:
    """Answers each percept of the world with the agent's action, as fast as it can.

    A robot's own link has the same constructor: it calls ``on_percept`` with a percept made from
    the robot's sensors, at the rate at which the agent shall tick, and carries out what is
    returned; no values are returned if something was wrong. Before the agent ends, ``close()`` is
    called, which must leave the robot at rest. A domain names its link in `Domain.link`.
    """

    def __init__(self, node: Node, world: str, on_percept: OnPercept) -> None:
        self._on_percept = on_percept
        # One message is used again for all answers: publishing copies it.
        self._action = msg.Action(agent=names.own_name(node))
        self._actions = node.create_publisher(
            msg.Action, names.in_swarm(node, world, names.ACTIONS), qos.CYCLE
        )
        self._subscription = node.create_subscription(
            msg.Percept, names.PERCEPT, self._answer, qos.CYCLE
        )

    def _answer(self, percept: msg.Percept) -> None:
        values, say = self._on_percept(percept)
        action = self._action
        action.sequence = percept.sequence
        action.values = values
        action.say = say
        self._actions.publish(action)

    def close(self) -> None:
        """Do nothing: a world notices by itself that an agent is gone."""
