"""ROS domain ids: chosen so that swarms on one machine do not hear each other."""

from __future__ import annotations

import contextlib
import os
import socket
from collections.abc import Iterator

from hitab_client.run_folder import running_swarms

LOOKED_AT = 10
"""Participants whose ports are tried."""


def chosen_by_user() -> int | None:
    """Return the user's own ROS_DOMAIN_ID, if set."""
    value = os.environ.get("ROS_DOMAIN_ID", "")
    return int(value) if value.isdigit() else None


def for_swarm() -> int:
    """Return the domain id for a new swarm: the user's, else 0, else one that nobody uses.

    Other programs may use 0: plain ROS tools, which are to find the swarm, look for it there.
    """
    own = chosen_by_user()
    if own is not None:
        return own
    taken = {record.domain_id for _, record in running_swarms()}
    if 0 not in taken:
        return 0
    others = [number for number in range(1, 102) if number not in taken]
    return next((number for number in others if not is_used_here(number)), others[0])


def is_used_here(number: int) -> bool:
    """Return whether a program on this machine takes part in a ROS domain.

    Each DDS participant listens on two ports of its own, numbered from the lowest that are free,
    and most on one that they share (DDSI-RTPS 2.5, section 9.6.1). A domain seems unused if only
    participants beyond the first `LOOKED_AT` are left.
    """
    base = 7400 + 250 * number
    return any(map(_is_bound, (base, *range(base + 10, base + 10 + 2 * LOOKED_AT, 2))))


def _is_bound(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("", port))
        except OSError:
            return True
    return False


@contextlib.contextmanager
def reserved() -> Iterator[int]:
    """Reserve a domain id that is free on this machine, for the duration of the context.

    Programs that chose a domain by hand are looked for; those that reserve one, as this does, are
    kept off it.
    """
    from domain_coordinator import domain_id

    taken = {record.domain_id for _, record in running_swarms()} | {chosen_by_user()}
    with contextlib.ExitStack() as refused:
        while True:
            stack = contextlib.ExitStack()
            number = stack.enter_context(domain_id())
            if number not in taken and not is_used_here(number):
                break
            refused.push(stack)
        with stack:
            yield number
