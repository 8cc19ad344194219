"""Checks of ROS: installation, DDS and domain."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from hitab_bringup.doctor.finding import ERROR, WARNING, Finding, judged
from hitab_client import domain_ids
from hitab_client.connecting.dds_profile import (
    INTERFACE,
    LOOPBACK,
    NETWORK,
    PEERS,
    RANGE,
    SERVER,
    VARIABLES,
    choose_profile,
)
from hitab_client.connecting.ros_environment import is_from_wheels
from hitab_core import way_to_install

DISTRO = "jazzy"
FAST_DDS = "rmw_fastrtps_cpp"
SAFE_DOMAINS = 102
"""Number of domains, from 0, whose ports no other program of the system uses."""


def installation() -> Iterator[Finding]:
    """Check that ROS and the messages can be loaded."""
    try:
        import hitab_msgs.msg
        import hitab_msgs.srv  # noqa: F401
        import rclpy
    except ImportError as wrong:
        yield Finding("ROS", f"cannot be loaded: {wrong}", ERROR, way_to_install())
        return
    place = Path(rclpy.__file__).resolve().parents[1]
    wheels = is_from_wheels()  # wheels are always of the required distribution
    distro = os.environ.get("ROS_DISTRO", "") or (DISTRO if wheels else "of unknown distribution")
    text = f"{distro}, from {'wheels' if wheels else 'an installation'} ({place})"
    way_out = f"HiTAB is made for ROS 2 {DISTRO}: use a terminal without another one's set-up file"
    yield judged("ROS", text, distro == DISTRO, way_out)


def middleware() -> Iterator[Finding]:
    """Check the DDS implementation and its profile."""
    rmw = os.environ.get("RMW_IMPLEMENTATION") or FAST_DDS
    text = f"{rmw}; HiTAB's DDS profiles are for Fast DDS, {FAST_DDS}"
    yield judged("DDS", text, rmw == FAST_DDS, "unset RMW_IMPLEMENTATION")
    environment = dict(os.environ)
    choose_profile(environment)
    profiles = {environment[name] for name in VARIABLES if environment.get(name)}
    own = [name for name in profiles if Path(name).name not in (LOOPBACK.name, NETWORK.name)]
    level, way_out = "ok", ""
    if missing := [name for name in own if not Path(name).is_file()]:
        text, level = f"there is no DDS profile {missing[0]}", ERROR
        way_out = f"unset {' '.join(VARIABLES)}"
    elif own:
        text = f"by your own DDS profile {own[0]}"
    elif server := os.environ.get(SERVER):
        text = f"by the server {server}, without which no node finds another ({SERVER})"
    elif any(Path(name).name == LOOPBACK.name for name in profiles):
        text = "of processes on this computer only"
    elif environment[RANGE] == "OFF":
        text, level, way_out = f"{RANGE} is OFF: no node finds another", ERROR, f"unset {RANGE}"
    else:
        chosen = {RANGE: environment[RANGE]} | {
            name: environment[name] for name in (PEERS, INTERFACE) if environment.get(name)
        }
        text = "of other computers in the network, too ({})".format(
            ", ".join(f"{name}={value}" for name, value in chosen.items())
        )
    yield Finding("discovery", text, level, way_out)
    if os.environ.get("ROS_LOCALHOST_ONLY") == "1":
        text = "ROS_LOCALHOST_ONLY=1 replaces HiTAB's DDS profile with one that finds 32 processes"
        way_out = f"unset ROS_LOCALHOST_ONLY; {RANGE}=LOCALHOST says the same"
        yield Finding("discovery", text, WARNING, way_out)


def domain() -> Iterator[Finding]:
    """Check the ROS domain, if given; `problems` checks its form."""
    number = domain_ids.chosen_by_user()
    if number is None:
        text = "not chosen: each swarm gets a free one, and commands find it (0 first)"
        yield Finding("ROS domain", text)
        return
    mean = "all commands mean swarms in this domain"
    text = f"{number}: {mean if number < SAFE_DOMAINS else 'its ports may be in use by others'}"
    yield judged("ROS domain", text, number < SAFE_DOMAINS, "choose a ROS_DOMAIN_ID up to 101")
