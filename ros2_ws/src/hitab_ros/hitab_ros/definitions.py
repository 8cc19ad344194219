"""Refuses to talk to nodes that define the project's messages differently.

DDS matches endpoints by the name of their type. Two versions of a message would be matched, and
misread. ROS 2 Jazzy announces a hash of each endpoint's definition, which is compared here.
"""

from __future__ import annotations

import functools
import json
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from rclpy.node import Node

from hitab_ros.checks import PACKAGE
from hitab_ros.spinning import FinalError


class DefinitionsDifferError(FinalError):
    """Another node defines a message differently; restarting does not help."""


@functools.cache
def own_hash(kind: str) -> str:
    """Return the hash of a message as this process defines it.

    Args:
        kind: such as ``hitab_msgs/msg/Percept``.
    """
    package, folder, name = kind.split("/")
    file = Path(get_package_share_directory(package)) / folder / f"{name}.json"
    hashes = json.loads(file.read_text(encoding="utf-8"))["type_hashes"]
    return str(next(one["hash_string"] for one in hashes if one["type_name"] == kind))


def refuse_other_definitions(node: Node) -> None:
    """Raise if a discovered node defines one of the project's messages differently.

    One topic of each type is looked at: of two versions in one ROS domain, the one that starts
    later finds the other.

    Raises:
        DefinitionsDifferError: naming the node and the message.
    """
    seen: set[str] = set()
    for topic, kinds in node.get_topic_names_and_types():
        for kind in kinds:
            if kind in seen or not kind.startswith(f"{PACKAGE}/msg/"):
                continue
            seen.add(kind)
            ends = node.get_publishers_info_by_topic(topic)
            for end in [*ends, *node.get_subscriptions_info_by_topic(topic)]:
                if str(end.topic_type_hash) != own_hash(kind):
                    name = f"{end.node_namespace.rstrip('/')}/{end.node_name}"
                    raise DefinitionsDifferError(
                        f"{name} defines {kind} differently: it runs another version of HiTAB; "
                        "install the same version everywhere and run scripts/setup, or use "
                        "another ROS_DOMAIN_ID"
                    )
