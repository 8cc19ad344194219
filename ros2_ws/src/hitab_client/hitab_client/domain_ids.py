"""ROS domain ids: chosen so that swarms on one machine do not hear each other."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator

from hitab_client.run_folder import running_swarms


def chosen_by_user() -> int | None:
    """Return the user's own ROS_DOMAIN_ID, if set."""
    value = os.environ.get("ROS_DOMAIN_ID", "")
    return int(value) if value.isdigit() else None


def for_swarm() -> int:
    """Return the domain id for a new swarm: the user's, else 0, else a free one."""
    own = chosen_by_user()
    if own is not None:
        return own
    taken = {record.domain_id for _, record in running_swarms()}
    return next(number for number in range(102) if number not in taken)


@contextlib.contextmanager
def reserved() -> Iterator[int]:
    """Reserve a domain id that is free on this machine, for the duration of the context."""
    from domain_coordinator import domain_id

    taken = {record.domain_id for _, record in running_swarms()} | {chosen_by_user()}
    with contextlib.ExitStack() as refused:
        while True:
            stack = contextlib.ExitStack()
            number = stack.enter_context(domain_id())
            if number not in taken:
                break
            refused.push(stack)
        with stack:
            yield number
