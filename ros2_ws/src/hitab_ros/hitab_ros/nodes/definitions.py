"""Check that other nodes define HiTAB's messages and services in the same way.

DDS matches endpoints by the name of their type. Two versions of a message or of a service would be
matched and misread. ROS 2 Jazzy announces a hash of each endpoint's definition, which is compared
here.
"""

from __future__ import annotations

import functools
import json
import sys
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from rclpy.node import Node

from hitab_core import way_to_install
from hitab_ros.messages.checks import PACKAGE
from hitab_ros.nodes.spinning import FinalError


class DefinitionsDifferError(FinalError):
    """Another node defines a message or service differently; restarting does not help."""


def share_folder(package: str) -> Path:
    """Return the folder with the data of a ROS package.

    Raises:
        LookupError: if the package is not installed.
    """
    try:
        return Path(get_package_share_directory(package))
    except (LookupError, OSError):  # OSError: no AMENT_PREFIX_PATH, as with ROS from wheels
        if (folder := Path(sys.prefix, "share", package)).is_dir():
            return folder
        raise LookupError(f"the ROS package {package} is not installed") from None


@functools.cache
def own_hashes(kind: str) -> dict[str, str]:
    """Return the hashes of a definition of this process, and of all its parts.

    Args:
        kind: type, such as ``hitab_msgs/msg/Percept`` or ``hitab_msgs/srv/Place_Request``.
    """
    package, folder, name = kind.split("/")
    file = share_folder(package) / folder / f"{name.split('_')[0]}.json"
    hashes = json.loads(file.read_text(encoding="utf-8"))["type_hashes"]
    return {one["type_name"]: one["hash_string"] for one in hashes}


def own_hash(kind: str) -> str:
    """Return the hash of a definition of this process."""
    return own_hashes(kind)[kind]


def check_same_message_version(node: Node) -> None:
    """Check that all discovered nodes define HiTAB's messages and services as this process does.

    One topic or service of each type is checked: of two versions in one ROS domain, the one that
    starts later finds the other.

    Raises:
        DefinitionsDifferError: if one differs; names the node and the message.
    """
    seen: set[str] = set()
    for topic, kinds in node.get_topic_names_and_types():
        for kind in kinds:
            if kind.startswith(f"{PACKAGE}/msg/") and kind not in seen:
                seen.add(kind)
                _compare(node, topic, kind, plain=False)
    for service, kinds in node.get_service_names_and_types():
        for kind in kinds:
            if kind.startswith(f"{PACKAGE}/srv/") and kind not in seen:
                seen.add(kind)
                # DDS knows a service as two topics.
                _compare(node, f"rq{service}Request", f"{kind}_Request", plain=True)
                _compare(node, f"rr{service}Reply", f"{kind}_Response", plain=True)


def _compare(node: Node, topic: str, kind: str, *, plain: bool) -> None:
    """Compare the definitions of a topic's endpoints; ``plain`` means that DDS has named it."""
    ends = node.get_publishers_info_by_topic(topic, plain)
    for end in [*ends, *node.get_subscriptions_info_by_topic(topic, plain)]:
        if str(end.topic_type_hash) != own_hash(kind):
            name = f"{end.node_namespace.rstrip('/')}/{end.node_name}"
            raise DefinitionsDifferError(
                f"{name} defines {kind} differently: it runs another version of HiTAB; "
                f"install the same version everywhere (here, {way_to_install()}), or use "
                "another ROS_DOMAIN_ID"
            )
