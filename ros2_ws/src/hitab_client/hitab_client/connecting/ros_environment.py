"""Check of the environment for ROS, without loading ROS.

The check comes first, because ROS ends a process whose middleware is not installed.
"""

from __future__ import annotations

import errno
import os
import re
import socket
import sys
import sysconfig
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

from hitab_client.connecting.dds_profile import (
    INTERFACE,
    RANGE,
    SERVER,
    SERVERS,
    is_of_this_machine,
)
from hitab_client.errors import SwarmError
from hitab_core import has
from hitab_ros.timing import POLL_S

DOMAINS = 233
"""Number of ROS domains; ports for more would be above 65535."""

SERVER_PORT, DISCARD = 11811, 9
ADDRESS = re.compile(r"\d+\.\d+\.\d+\.\d+")

RANGES = ("LOCALHOST", "SUBNET", "SYSTEM_DEFAULT", "OFF")

Problem = tuple[str, str, str]
"""The subject, the fault and the way out."""


def problems() -> Iterator[Problem]:
    """Yield the reasons why ROS would not start, or would ignore its variables."""
    said = os.environ.get("ROS_DOMAIN_ID", "")
    if said and not (said.isdecimal() and int(said) < DOMAINS):
        fault = f"ROS_DOMAIN_ID={said} is not a number from 0 to {DOMAINS - 1}"
        yield "ROS domain", fault, "unset ROS_DOMAIN_ID, or choose a number up to 101"
    found, installed = find_spec("rclpy"), Path(sysconfig.get_path("purelib")) / "rclpy"
    if found is not None and installed.exists() and not is_from_wheels():
        fault = f"rclpy is loaded from {found.origin} instead of {installed}"
        way_out = "unset PYTHONPATH, or use a terminal without another ROS's set-up file"
        yield "ROS", fault, way_out
    chosen = os.environ.get("RMW_IMPLEMENTATION", "")
    folders = [Path(name) for name in os.environ.get("LD_LIBRARY_PATH", "").split(":") if name]
    if chosen and folders and not any((f / f"lib{chosen}.so").exists() for f in folders):
        fault = f"RMW_IMPLEMENTATION={chosen} is not installed"
        yield "DDS", fault, "unset RMW_IMPLEMENTATION, or install that middleware"
    said = os.environ.get(RANGE, "")
    if said and said not in RANGES:
        yield "discovery", f"{RANGE}={said} is none of {', '.join(RANGES)}", f"unset {RANGE}"
    here = is_of_this_machine(os.environ)
    if here and (wrong := _no_answer("127.0.0.1", DISCARD)) == os.strerror(errno.ENETUNREACH):
        fault = f"this machine cannot reach itself at 127.0.0.1: {wrong}"
        yield "network", fault, "start its loopback interface with `sudo ip link set lo up`"
    yield from _without_server(os.environ.get(SERVER, ""))
    interfaces = [name for _, name in socket.if_nameindex()]
    said = os.environ.get(INTERFACE, "")
    if said and said not in interfaces and not ADDRESS.fullmatch(said):
        fault = f"{INTERFACE}={said}: this computer has no such interface {has(interfaces, said)}"
        yield "network", fault, f"choose another, or unset {INTERFACE}"
    if os.environ.get("ROS_SECURITY_ENABLE") == "true" and is_from_wheels():
        fault = "ROS_SECURITY_ENABLE=true, but ROS from wheels has no DDS security"
        way_out = "unset ROS_SECURITY_ENABLE, or use HiTAB with an installed ROS 2 Jazzy"
        yield "security", fault, way_out


def _without_server(said: str) -> Iterator[Problem]:
    """Yield the reasons why nodes would not find each other by the named discovery servers."""
    servers = [(host, int(port or SERVER_PORT)) for host, port in SERVERS.findall(said)]
    if servers and all(why := [_no_answer(*server) for server in servers]):
        fault = f"{SERVER}={said}: there is no server ({', '.join(dict.fromkeys(why))})"
        yield "discovery", fault, f"start the server, or unset {SERVER} ROS_SUPER_CLIENT"


def _no_answer(host: str, port: int) -> str:
    """Return why a port receives no messages; empty if it may."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.settimeout(POLL_S)
        try:
            probe.connect((host, port))
            probe.send(b"")
            probe.recv(1)
        except TimeoutError:
            return ""
        except OSError as error:
            return error.strerror or str(error)
    return ""


def is_from_wheels() -> bool:
    """Whether ROS is installed in this Python environment, instead of on the system."""
    found = find_spec("rclpy")
    place = Path(found.origin or "").resolve() if found is not None else Path("/")
    return place.is_relative_to(Path(sys.prefix).resolve())


def refuse_problems() -> None:
    """Raise if ROS would not start.

    Raises:
        SwarmError: if so; names the variable and the way out.
    """
    for _, fault, way_out in problems():
        raise SwarmError(f"{fault}; {way_out}")
