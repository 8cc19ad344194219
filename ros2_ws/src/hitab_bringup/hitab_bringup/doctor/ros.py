"""Checks ROS: where it is from, DDS, the domain, and who is there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from hitab_bringup.doctor.finding import Finding, error, warning
from hitab_client import domain_ids
from hitab_client.dds_profile import LOOPBACK, NETWORK, RANGE, VARIABLES, choose_profile
from hitab_client.ros_environment import is_from_wheels, problems
from hitab_core import quantity

DISTRO = "jazzy"
FAST_DDS = "rmw_fastrtps_cpp"
COMMON = 102
"""Domains whose ports no other program of the system uses."""

LOOK_SECONDS = 2.0


def installation() -> Iterator[Finding]:
    """Check that ROS and the messages can be loaded."""
    try:
        import rclpy
    except ImportError as wrong:
        yield error("ROS", f"cannot be loaded: {wrong}", "run scripts/setup and use scripts/hitab")
        return
    place = Path(rclpy.__file__).resolve().parents[1]
    distro = os.environ.get("ROS_DISTRO", "") or "of unknown distribution"
    told = f"{distro}, from {'wheels' if is_from_wheels() else 'an installation'} ({place})"
    if distro == DISTRO:
        yield Finding("ROS", told)
    else:
        yield warning("ROS", told, f"HiTAB is made for ROS 2 {DISTRO}: use scripts/hitab")
    try:
        import hitab_msgs.msg
        import hitab_msgs.srv  # noqa: F401
    except ImportError as wrong:
        yield error("messages", f"hitab_msgs cannot be loaded: {wrong}", "run scripts/setup")
    else:
        yield Finding("messages", "hitab_msgs is built")


def middleware() -> Iterator[Finding]:
    """Check the DDS implementation and its profile."""
    rmw = os.environ.get("RMW_IMPLEMENTATION") or FAST_DDS
    if rmw == FAST_DDS:
        yield Finding("DDS", f"Fast DDS ({rmw})")
    else:
        yield warning(
            "DDS", f"{rmw}; HiTAB's DDS profiles are for Fast DDS", "unset RMW_IMPLEMENTATION"
        )
    said = os.environ.get(RANGE, "")
    environment = dict(os.environ)
    choose_profile(environment)
    profiles = {environment[name] for name in VARIABLES if environment.get(name)}
    own = [name for name in profiles if Path(name).name not in (LOOPBACK.name, NETWORK.name)]
    if missing := [name for name in own if not Path(name).is_file()]:
        yield error(
            "discovery", f"there is no DDS profile {missing[0]}", f"unset {' '.join(VARIABLES)}"
        )
    elif own:
        yield Finding("discovery", f"by your own DDS profile {own[0]}")
    elif any(Path(name).name == LOOPBACK.name for name in profiles):
        yield Finding("discovery", "of processes on this computer only")
    elif environment[RANGE] == "OFF":
        yield error("discovery", f"{RANGE} is OFF: nobody finds anybody", f"unset {RANGE}")
    else:
        yield Finding("discovery", f"of other computers in the network, too ({RANGE}={said})")
    if os.environ.get("ROS_LOCALHOST_ONLY") == "1":
        yield warning(
            "discovery",
            "ROS_LOCALHOST_ONLY=1 replaces HiTAB's DDS profile with one that finds 32 processes",
            f"unset ROS_LOCALHOST_ONLY; {RANGE}=LOCALHOST says the same",
        )


def domain() -> Iterator[Finding]:
    """Check the ROS domain."""
    said = os.environ.get("ROS_DOMAIN_ID", "")
    if not said:
        yield Finding(
            "ROS domain", "not chosen: each swarm gets a free one, and commands find it (0 first)"
        )
        return
    if wrong := [problem for problem in problems() if problem[0] == "ROS domain"]:
        yield error(*wrong[0])
    elif (number := int(said)) >= COMMON:
        yield warning(
            "ROS domain",
            f"{number}: its ports may be in use by other programs",
            "choose a ROS_DOMAIN_ID up to 101",
        )
    else:
        yield Finding("ROS domain", f"{number}: all commands mean swarms in this domain")


def neighbors(started_here: bool) -> Iterator[Finding]:
    """Look who is in the ROS domain, and whether all have the same message definitions.

    Args:
        started_here: whether `hitab up` has started a swarm in this domain.
    """
    from hitab_bringup.doctor.agents import told_by
    from hitab_client import RosLink, SwarmClient
    from hitab_client.swarm_choice import reported_on
    from hitab_ros import FinalError, refuse_other_definitions

    number = domain_ids.chosen_by_user() or 0
    with RosLink(number) as link:
        agents = SwarmClient(link)
        # Looks the whole time: nobody knows how many there are.
        link.spin_until(lambda: None if started_here else agents.discover(), LOOK_SECONDS)
        try:
            refuse_other_definitions(link.node)
        except FinalError as wrong:
            yield error("nodes", str(wrong), "run scripts/setup where that node was started")
        found = {topic.rsplit("/", 1)[0].lstrip("/") for topic in reported_on(link)}
    nodes = quantity(len(found), "agent or world", "agents and worlds")
    who = f"{nodes} in ROS domain {number}"
    if found and not started_here:
        yield warning(
            "nodes",
            f"{who}, started by hand or on another computer",
            "to be alone, choose another ROS_DOMAIN_ID",
        )
        yield from told_by(agents.statuses)
    else:
        yield Finding("nodes", who)
