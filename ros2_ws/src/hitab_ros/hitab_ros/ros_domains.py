"""Free ROS domains on this machine."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable, Iterator

LOOKED_AT = 10
"""Number of participants whose ports are tried."""


def is_used_here(number: int) -> bool:
    """Return whether a program on this machine takes part in a ROS domain.

    Each DDS participant listens on two ports of its own, the lowest free ones, and most also on a
    shared port (DDSI-RTPS 2.5, section 9.6.1). A domain seems unused if only participants beyond
    the first `LOOKED_AT` are left.
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
def reserved_domain(is_taken: Callable[[int], bool] = lambda number: False) -> Iterator[int]:
    """Reserve a ROS domain that is unused on this machine, for the duration of the context.

    Domains of programs that chose one by hand are detected; programs that reserve one, as here,
    exclude each other.

    Args:
        is_taken: returns whether a domain is excluded for another reason.
    """
    from domain_coordinator import domain_id

    with contextlib.ExitStack() as refused:
        while True:
            stack = contextlib.ExitStack()
            number = stack.enter_context(domain_id())
            if not is_taken(number) and not is_used_here(number):
                break
            refused.push(stack)
        try:
            yield number
        finally:
            stack.close()  # without the error: `domain_id` would swallow an OSError
