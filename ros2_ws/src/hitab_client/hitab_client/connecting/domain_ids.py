"""ROS domain ids, chosen so that swarms on one machine do not receive each other's messages."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Collection, Iterator

from hitab_client.runs.run_folder import swarms_here
from hitab_ros.ros_domains import is_used_here, reserved_domain


def chosen_by_user() -> int | None:
    """Return the user's own ROS_DOMAIN_ID, if set."""
    value = os.environ.get("ROS_DOMAIN_ID", "")
    return int(value) if value.isdigit() else None


def for_swarm(refused: Collection[int] = (), *, is_free: bool = True) -> int:
    """Return the domain id for a new swarm: the user's, else 0, else an unused one.

    Other programs may use 0 as well: plain ROS tools look for the swarm in domain 0.

    Args:
        refused: domain ids in which the swarm's names are in use.
        is_free: whether the swarm can be in any domain; otherwise only 0 is possible, since
            drivers of its robots or other machines, which are started elsewhere, are in domain 0.
    """
    own = chosen_by_user()
    if own is not None:
        return own
    if not is_free:
        return 0
    taken = {record.domain_id for _, record in swarms_here()} | set(refused)
    if 0 not in taken:
        return 0
    others = [number for number in range(1, 102) if number not in taken]
    return next((number for number in others if not is_used_here(number)), others[0])


@contextlib.contextmanager
def reserved() -> Iterator[int]:
    """Reserve a domain id that is free on this machine, for the duration of the context.

    Domains of programs that chose one by hand are detected; programs that reserve one, as here,
    exclude each other.
    """
    taken = {record.domain_id for _, record in swarms_here()} | {chosen_by_user()}
    with reserved_domain(taken.__contains__) as number:
        yield number
