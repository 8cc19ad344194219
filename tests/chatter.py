"""Plain ROS programs that know nothing of this project, to see who hears whom.

    python chatter.py talk FIRST COUNT     says "ready" once it talks with COUNT participants
    python chatter.py hear COUNT SECONDS   prints how many it has heard

DDS finds participants, whatever their process; each takes a port of its own.
"""

from __future__ import annotations

import sys
import time

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String


def join(name: str) -> Node:
    """Return a node with a participant of its own."""
    context = Context()
    rclpy.init(args=[], context=context)
    return rclpy.create_node(
        name, context=context, enable_rosout=False, start_parameter_services=False
    )


def talk(first: int, count: int) -> None:
    """Say something once with each participant, kept for those that come later."""
    qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    kept = []
    for number in range(first, first + count):
        node = join(f"talker_{number}")
        publisher = node.create_publisher(String, "chatter", qos)
        publisher.publish(String(data=str(number)))
        kept.append((node, publisher))
    print("ready", flush=True)
    sys.stdin.read()


def hear(count: int, seconds: float) -> None:
    """Listen until so many were heard, or for so long."""
    heard: set[str] = set()
    qos = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node = join("listener")
    node.create_subscription(String, "chatter", lambda message: heard.add(message.data), qos)
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    deadline = time.monotonic() + seconds
    while len(heard) < count and time.monotonic() < deadline:
        executor.spin_once(timeout_sec=0.1)
    print(len(heard), flush=True)


if __name__ == "__main__":
    role, *numbers = sys.argv[1:]
    {"talk": talk, "hear": hear}[role](*map(int, numbers))
