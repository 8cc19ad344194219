"""The mounts of sensors from tf2, where tf2 is installed."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from rclpy.node import Node
from rclpy.time import Time

from hitab_core import HitabError
from hitab_robots.mount import Mount


def mounts_of_tf(node: Node, base_frame: str) -> Callable[[str], Mount | None]:
    """Return a function from a sensor's frame to its mount; None while tf2 does not know it.

    Args:
        node: the node that listens to tf2.
        base_frame: the robot's own frame, such as ``base_link``.

    Raises:
        HitabError: if tf2 is not installed.
    """
    try:
        tf2 = import_module("tf2_ros")  # comes with an installed ROS 2 only
    except ImportError as error:
        raise HitabError(
            f"the parameter base_frame needs tf2_ros, which cannot be imported ({error}); "
            "install it with ROS 2, or leave base_frame empty and give each sensor's place by "
            "its parameters x, y and yaw"
        ) from error

    buffer = tf2.Buffer(node=node)
    listener = tf2.TransformListener(buffer, node)
    known: dict[str, Mount] = {}

    def mount(frame: str) -> Mount | None:
        if frame not in known:
            try:
                found: Any = buffer.lookup_transform(base_frame, frame, Time()).transform
            except tf2.TransformException:
                return None
            place, turn = found.translation, found.rotation
            known[frame] = Mount.of_transform(
                (place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w)
            )
        return known[frame]

    mount.listener = listener  # type: ignore[attr-defined]  # lives as long as the function
    return mount
