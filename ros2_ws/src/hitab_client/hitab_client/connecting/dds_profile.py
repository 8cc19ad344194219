"""DDS settings of HiTAB's processes: discovery, dropping of killed processes, and memory.

By default all traffic stays on this machine. ROS's own `LOCALHOST` range discovers only 32
processes and listens on all interfaces, so it is replaced by a profile that binds to 127.0.0.1.
Other ROS programs that use `LOCALHOST` in the same domain are discovered, and discover ours.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, MutableMapping
from pathlib import Path
from typing import Any

from hitab_ros.timing import POLL_S

VARIABLES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
"""The variables that older and newer versions of Fast DDS read."""

GIVES_BACK = {"RMW_FASTRTPS_USE_QOS_FROM_XML": "1", "MALLOC_MMAP_THRESHOLD_": "1000000"}
"""The first lets a payload shrink again, as the profile asks; the other makes the C library return
large freed blocks."""

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
HERE, BY_PROFILE, NETWORK_RANGE = "LOCALHOST", "SYSTEM_DEFAULT", "SUBNET"

PEERS, INTERFACE, SERVER = "ROS_STATIC_PEERS", "HITAB_INTERFACE", "ROS_DISCOVERY_SERVER"
"""The variables that name other machines, or the interface to them. The network profile reads the
second."""

SERVERS = re.compile(r"(?:^|;) *(?:UDPv4:\[)?([\w.-]+)\]?(?::(\d+))? *(?=;|$)")
"""Pattern of the addresses and ports of discovery servers."""

LOOPBACK = Path(__file__).with_name("dds_loopback.xml")
"""Profile for processes on this machine only."""

NETWORK = Path(__file__).with_name("dds_network.xml")
"""Profile for communication with other machines."""

PORTS = 120
"""Maximum number of processes with their own ports in a ROS domain."""

_SHARED_BY = 50  # processes that may announce themselves each second
_MISSED = 5  # missed announcements after which a process is dropped
SHORTEST_LEASE_S = 30.0
"""Silence after which a process is dropped, s; longer than any pause on a busy machine. A dropped
process that still runs is not fully rediscovered, so it restarts (`hitab_ros.presence`)."""

_NAMESPACE = "http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles"


def choose_profile(environment: MutableMapping[str, str], loopback: Path = LOOPBACK) -> None:
    """Set up discovery between processes with this environment, unless the user has a profile.

    Args:
        environment: environment variables; the profile and the discovery range are set in it.
        loopback: profile file for this machine only.
    """
    if _chosen(environment) - {LOOPBACK.name, NETWORK.name}:
        environment.setdefault(RANGE, HERE)
        return
    said = environment.get(RANGE) or HERE
    stays = is_of_this_machine(environment)
    if stays and environment.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp").startswith("rmw_fast"):
        profile, environment[RANGE] = loopback, BY_PROFILE
    else:
        # Without our profile SYSTEM_DEFAULT would mean the whole network.
        reaches = NETWORK_RANGE if said in (HERE, BY_PROFILE) else said
        profile, environment[RANGE] = NETWORK, HERE if stays else reaches
        environment.setdefault(INTERFACE, "")  # Fast DDS prints an error if there is none
    for name in VARIABLES:
        environment[name] = str(profile)
    environment.update(GIVES_BACK)


def is_of_this_machine(environment: Mapping[str, str]) -> bool:
    """Whether discovery is limited to this machine by the variables and HiTAB's profiles.

    False if the user names other machines, or has a profile, which then decides.
    """
    chosen, said = _chosen(environment), environment.get(RANGE) or HERE
    if chosen - {LOOPBACK.name, NETWORK.name} or _names_others(environment):
        return False
    return said == HERE or (said == BY_PROFILE and LOOPBACK.name in chosen)


def _names_others(environment: Mapping[str, str]) -> bool:
    """Whether a variable names other machines, or an interface to them."""
    servers = [host for host, _ in SERVERS.findall(environment.get(SERVER, ""))]
    away = any(host != "localhost" and not host.startswith("127.") for host in servers)
    return away or bool(environment.get(PEERS) or environment.get(INTERFACE))


def _chosen(environment: Mapping[str, str]) -> set[str]:
    """Return the names of the profiles in the variables."""
    return {Path(environment[name]).name for name in VARIABLES if environment.get(name)}


def profile_for(folder: Path, processes: int) -> Path:
    """Write the profile of a swarm that stays on this machine, and return its file.

    A new process misses the answers to its first announcement, since it cannot receive yet, and
    discovers the others at their next announcements. So every process announces itself four times
    a second. The cost grows with the square of their number, so from 25 processes on they announce
    themselves less often, which limits it to a tenth of a core or two.

    Args:
        folder: folder for the profile.
        processes: number of processes in the swarm.
    """
    from xml.etree import ElementTree

    period = max(POLL_S, (processes / _SHARED_BY) ** 2)
    tree: Any = ElementTree.parse(LOOPBACK)
    _set_duration(tree, "leaseAnnouncement", period)
    _set_duration(tree, "leaseDuration", max(SHORTEST_LEASE_S, _MISSED * period))
    peers = str(max(PORTS, processes + PORTS // 4))
    tree.find(f".//{{{_NAMESPACE}}}maxInitialPeersRange").text = peers
    ElementTree.register_namespace("", _NAMESPACE)
    file = folder / LOOPBACK.name
    tree.write(file, encoding="UTF-8", xml_declaration=True)
    return file


def _set_duration(tree: Any, name: str, seconds: float) -> None:
    for unit, value in (("sec", int(seconds)), ("nanosec", int(seconds % 1 * 1e9))):
        tree.find(f".//{{{_NAMESPACE}}}{name}/{{{_NAMESPACE}}}{unit}").text = str(value)
