"""Signs of life: one small message per process, so that others notice quickly when it hangs."""

from __future__ import annotations

from hitab_msgs.msg import Alive

from hitab_ros import names, qos
from hitab_ros.guarded_node import GuardedNode
from hitab_ros.steady_timer import steady_timer

PERIOD_S = 0.5
"""Time between two signs of life, s, by the machine's clock: a paused world is alive, too."""


def give_signs_of_life(node: GuardedNode, swarm: str = "") -> None:
    """Publish signs of life from now on, in the name of a node's agent, host or world.

    They come from the thread that handles the node's other events, so a process that hangs in one
    of them gives none. Without a subscriber nothing is sent.

    Args:
        node: that stands for its process; its namespace gives the name.
        swarm: identity of its swarm; empty: none.
    """
    publisher = node.create_publisher(Alive, names.in_swarm(node, names.ALIVE), qos.SIGNS_OF_LIFE)
    sign = Alive(process=names.own_name(node), swarm=swarm)

    def show() -> None:
        publisher.publish(sign)

    steady_timer(node, PERIOD_S, show)
