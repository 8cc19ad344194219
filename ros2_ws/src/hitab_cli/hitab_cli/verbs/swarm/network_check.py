"""Check of the network between the computers on which `hitab doctor --network 10` runs."""

from __future__ import annotations

import math
import os
import socket
import time
from collections.abc import Iterable, Iterator, Mapping

import psutil  # type: ignore[import-untyped]
from hitab_msgs.msg import MachineLink, MachineStatus

from hitab_bringup.doctor import ERROR, WARNING, Finding, judged
from hitab_client import OFFSET_MAX_S, MachineSigns, RosLink, console, domain_ids
from hitab_client.connecting.dds_profile import INTERFACE, RANGE, SERVER, is_of_this_machine
from hitab_core import HitabError
from hitab_ros import check_same_message_version, names, qos
from hitab_ros.timing import REPEAT_S, SILENT_AFTER_S

PREFIX, ABOUT = "/network_check", "network"
LOSS_MAX = 0.01

FIRST_PORT, PORTS_EACH = 7400, 250  # of DDS, and per domain


def network(seconds: float) -> Iterator[Finding]:
    """Listen to other computers and to machines of swarms; report who hears whom.

    Args:
        seconds: how long to listen, s.
    """
    here = is_of_this_machine(os.environ)
    addresses = {} if here else _addresses(os.environ.get(INTERFACE, ""))
    own = f"{socket.gethostname()} ({next(iter(addresses.values()), '127.0.0.1')})"
    where = ", ".join(f"{name} {address}" for name, address in addresses.items())
    yield Finding(ABOUT, f"this is {own}; it sends on {where or 'lo only'}")
    domain = domain_ids.chosen_by_user() or 0
    statuses: dict[str, MachineStatus] = {}
    with RosLink(domain) as link:
        signs = MachineSigns(link.node, PREFIX, "", own)
        topics: set[str] = set()
        began = time.monotonic()
        said = 0.0
        while (passed := time.monotonic() - began) < seconds:
            for topic in {*link.topics_of_type(names.MACHINE_TYPE)} - topics:
                topics.add(topic)
                if not topic.startswith(PREFIX):
                    hear = lambda status: statuses.update({status.machine: status})  # noqa: E731
                    link.subscribe(MachineStatus, topic, hear, qos.SIGNS_OF_LIFE)
            if passed >= said:
                said += REPEAT_S
                console.err().print(
                    f"listening in ROS domain {domain}, {seconds - passed:.0f} s left; heard: "
                    f"{', '.join([*signs.heard, *statuses]) or 'none'}"
                )
            link.spin()
        found = [one.link() for one in signs.heard.values()]
        try:
            check_same_message_version(link.node)
        except HitabError as error:
            yield Finding(ABOUT, str(error), ERROR)
    # A doctor elsewhere may end earlier; a machine of a swarm may not.
    yield from links(own, found, math.inf)
    for status in statuses.values():
        yield from links(status.machine, status.links, SILENT_AFTER_S)
    if not signs.heard and not statuses:
        yield nobody(seconds, domain, os.environ, here=here)


def links(own: str, heard: Iterable[MachineLink], age_max: float) -> Iterator[Finding]:
    """Yield what a machine hears of others; ``age_max`` is the silence that is reported, s."""
    for link in heard:
        text = f"{own} hears {link.machine}: {link.loss:.0%} lost"
        if link.age > age_max:
            text = f"{own} has not heard {link.machine} for {link.age:.0f} s"
            yield Finding(ABOUT, text, WARNING, f"look at {link.machine} and its cable")
            continue
        if math.isnan(link.delay):
            way_out = f"let the firewall of {link.machine} pass UDP from here"
            yield Finding(ABOUT, f"{text}; it does not hear {own}", WARNING, way_out)
            continue
        text += f", {link.delay * 1e3:.1f} ms one way, clock {link.offset:+.2f} s"
        if abs(link.offset) > OFFSET_MAX_S:
            yield Finding(
                ABOUT, text, WARNING, "set the clocks of both, such as by `chronyc makestep`"
            )
            continue
        way_out = "use a cable, or a less busy channel; see docs/network.md"
        yield judged(ABOUT, text, link.loss <= LOSS_MAX, way_out)


def nobody(seconds: float, domain: int, environment: Mapping[str, str], *, here: bool) -> Finding:
    """Return why perhaps no other computer was heard, and what to try first."""
    text = f"no other computer was heard in {seconds:g} s"
    if here:
        text += "; HiTAB's traffic stays on this computer"
        return Finding(ABOUT, text, WARNING, f"export {RANGE}=SUBNET, on all; see docs/network.md")
    first = FIRST_PORT + PORTS_EACH * domain
    ports = f"UDP ports {first} to {first + PORTS_EACH - 1}"
    other = "ROS_STATIC_PEERS with the addresses of all"
    if server := environment.get(SERVER):
        other = f"the same {SERVER}={server}"
    way_out = (
        f"run `hitab doctor --network {seconds:g}` on both at the same time with "
        f"ROS_DOMAIN_ID={domain}; let firewalls pass {ports}; if multicast is blocked, as in many "
        f"wireless networks, use {other}; see docs/network.md"
    )
    return Finding(ABOUT, text, WARNING, way_out)


def _addresses(interface: str) -> dict[str, str]:
    """Return the IPv4 address of each interface that is used, except the loopback's."""
    found = {
        name: address.address
        for name, addresses in psutil.net_if_addrs().items()
        for address in addresses
        if address.family == socket.AF_INET and not address.address.startswith("127.")
    }
    return {name: address for name, address in found.items() if interface in ("", name, address)}
