"""Whether ROS can start with the variables of the environment, found without loading ROS.

With a middleware that is not installed, ROS ends the process that loads it.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

from hitab_client.dds_profile import RANGE
from hitab_client.errors import SwarmError

DOMAINS = 233
"""Number of ROS domains; ports for more would be above 65535."""

RANGES = ("LOCALHOST", "SUBNET", "SYSTEM_DEFAULT", "OFF")

Problem = tuple[str, str, str]
"""What it is about, what is wrong, and the way out."""


def problems() -> Iterator[Problem]:
    """Yield why ROS would not start, or not as the variables say."""
    said = os.environ.get("ROS_DOMAIN_ID", "")
    if said and not (said.isdecimal() and int(said) < DOMAINS):
        told = f"ROS_DOMAIN_ID={said} is not a number from 0 to {DOMAINS - 1}"
        yield "ROS domain", told, "unset ROS_DOMAIN_ID, or choose a number up to 101"
    chosen = os.environ.get("RMW_IMPLEMENTATION", "")
    folders = [Path(name) for name in os.environ.get("LD_LIBRARY_PATH", "").split(":") if name]
    if chosen and folders and not any((f / f"lib{chosen}.so").exists() for f in folders):
        told = f"RMW_IMPLEMENTATION={chosen} is not installed"
        yield "DDS", told, "unset RMW_IMPLEMENTATION, or install that middleware"
    said = os.environ.get(RANGE, "")
    if said and said not in RANGES:
        yield "discovery", f"{RANGE}={said} is none of {', '.join(RANGES)}", f"unset {RANGE}"
    if os.environ.get("ROS_SECURITY_ENABLE") == "true" and is_from_wheels():
        told = "ROS_SECURITY_ENABLE=true, but ROS from wheels has no DDS security"
        way_out = "unset ROS_SECURITY_ENABLE, or use HiTAB with an installed ROS 2 Jazzy"
        yield "security", told, way_out


def is_from_wheels() -> bool:
    """Whether ROS is part of this Python environment instead of an installation of its own."""
    found = find_spec("rclpy")
    place = Path(found.origin or "").resolve() if found is not None else Path("/")
    return place.is_relative_to(Path(sys.prefix).resolve())


def refuse_problems() -> None:
    """Refuse to go on if ROS would not start.

    Raises:
        SwarmError: naming the variable and the way out.
    """
    for _, told, way_out in problems():
        raise SwarmError(f"{told}; {way_out}")
