"""ROS domain ids: chosen so that swarms on one machine do not hear each other."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Collection, Iterator

from hitab_client.run_folder import swarms_here
from hitab_ros.ros_domains import is_used_here, reserved_domain


def chosen_by_user() -> int | None:
    """Return the user's own ROS_DOMAIN_ID, if set."""
    value = os.environ.get("ROS_DOMAIN_ID", "")
    return int(value) if value.isdigit() else None


def for_swarm(refused: Collection[int] = (), *, has_world: bool = True) -> int:
    """Return the domain id for a new swarm: the user's, else 0, else an unused one.

    Other programs may use 0: plain ROS tools, which are to find the swarm, look for it there.

    Args:
        refused: where its names have turned out to be in use.
        has_world: a swarm without a world only has 0: the drivers of its robots, which are started
            elsewhere, are there.
    """
    own = chosen_by_user()
    if own is not None:
        return own
    if not has_world:
        return 0
    taken = {record.domain_id for _, record in swarms_here()} | set(refused)
    if 0 not in taken:
        return 0
    others = [number for number in range(1, 102) if number not in taken]
    return next((number for number in others if not is_used_here(number)), others[0])


@contextlib.contextmanager
def reserved() -> Iterator[int]:
    """Reserve a domain id that is free on this machine, for the duration of the context.

    Programs that chose a domain by hand are looked for; those that reserve one, as this does, are
    kept off it.
    """
    taken = {record.domain_id for _, record in swarms_here()} | {chosen_by_user()}
    with reserved_domain(taken.__contains__) as number:
        yield number
