"""Signs of life: one message per process, so that others quickly notice if it hangs."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from hitab_msgs.msg import Alive
from rclpy.node import Node

from hitab_ros import names, qos
from hitab_ros.steady_timer import steady_timer

HEARTBEAT_PERIOD_S = 0.5
"""Period of heartbeats by the machine's clock, s: a paused world is alive, too."""


def give_signs_of_life(node: Node, swarm: str = "", others: Iterable[str] = ()) -> None:
    """Publish signs of life from now on, in the name of a node's agent, host or world.

    Signs come from the thread that handles the node's other events, so a process that hangs in an
    event sends none. Without a subscriber nothing is sent.

    Args:
        node: node that represents its process; the last part of its namespace is the name.
        swarm: identity of the node's swarm, or empty.
        others: further names that represent the process, such as those of a host's commanders.
    """
    sign = Alive(process=names.own_name(node), agents=list(others), swarm=swarm)
    _give(node, names.in_swarm(node, names.ALIVE), sign, lambda: True)


def give_signs_of_operator(node: Node, prefix: str, is_present: Callable[[], object]) -> None:
    """Publish from now on that an operator of a swarm's agents is present.

    Args:
        node: node of the operator's console.
        prefix: namespace of the swarm.
        is_present: returns whether the operator is in reach of the console.
    """
    topic = names.of_swarm(names.OPERATORS, prefix)
    _give(node, topic, Alive(process=node.get_name()), is_present)


def _give(node: Node, topic: str, sign: Alive, is_present: Callable[[], object]) -> None:
    publisher = node.create_publisher(Alive, topic, qos.SIGNS_OF_LIFE)

    def show() -> None:
        if is_present():
            publisher.publish(sign)

    steady_timer(node, HEARTBEAT_PERIOD_S, show)
