"""Signs of life: one small message per process, so that others notice quickly when it hangs."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from hitab_msgs.msg import Alive
from rclpy.node import Node

from hitab_ros import names, qos
from hitab_ros.steady_timer import steady_timer

HEARTBEAT_PERIOD_S = 0.5
"""Period of heartbeats, s, by the machine's clock: a paused world is alive, too."""


def give_signs_of_life(node: Node, swarm: str = "", others: Iterable[str] = ()) -> None:
    """Publish signs of life from now on, in the name of a node's agent, host or world.

    They come from the thread that handles the node's other events, so a process that hangs in one
    of them gives none. Without a subscriber nothing is sent.

    Args:
        node: that stands for its process; its namespace gives the name.
        swarm: identity of its swarm, or empty.
        others: further names that stand for the process, such as those of a host's commanders.
    """
    signs = [Alive(process=name, swarm=swarm) for name in (names.own_name(node), *others)]
    _give(node, names.in_swarm(node, names.ALIVE), signs, lambda: True)


def give_signs_of_operator(node: Node, prefix: str, there: Callable[[], object]) -> None:
    """Publish from now on that a person who operates the agents of a swarm is there.

    Args:
        node: of the person's console.
        prefix: namespace of the swarm.
        there: returns whether the person is in reach of the console.
    """
    _give(node, names.of_swarm(names.OPERATORS, prefix), [Alive(process=node.get_name())], there)


def _give(node: Node, topic: str, signs: Iterable[Alive], there: Callable[[], object]) -> None:
    publisher = node.create_publisher(Alive, topic, qos.SIGNS_OF_LIFE)

    def show() -> None:
        for sign in signs if there() else ():
            publisher.publish(sign)

    steady_timer(node, HEARTBEAT_PERIOD_S, show)
