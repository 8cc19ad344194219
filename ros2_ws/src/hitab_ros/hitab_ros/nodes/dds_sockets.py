"""Sockets of DDS, which must receive nothing when a process leaves the ROS graph.

Fast DDS 2.14 destroys a participant only while no discovery message is handled. The waiting thread
holds a lock that the handler needs, so that one message at this moment blocks the process forever
(https://github.com/eProsima/Fast-DDS/issues/6513; seen in one of 700 departures while other
processes created and destroyed publishers). This loop is in compiled code and holds Python's lock,
so neither a signal nor another thread can end it. A process therefore first stops receiving.
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress

from hitab_ros.timing import TURN_S


def udp_sockets() -> set[int]:
    """Return the descriptors of this process's UDP sockets."""
    found = set()
    for number in map(int, os.listdir("/proc/self/fd")):
        with suppress(OSError), _opened(number) as one:
            if one.type == socket.SOCK_DGRAM and one.family in (socket.AF_INET, socket.AF_INET6):
                found.add(number)
    return found


def stop_receiving(sockets: Iterable[int]) -> None:
    """Stop receiving by these sockets; the process can still announce its departure."""
    for number in sockets:
        # The system reports that the socket is not connected, and shuts it down.
        with suppress(OSError), _opened(number) as one:
            one.shutdown(socket.SHUT_RD)
    time.sleep(TURN_S)


@contextmanager
def _opened(number: int) -> Iterator[socket.socket]:
    """Open a copy of a socket; closing the copy leaves the socket open."""
    copy = os.dup(number)
    try:
        one = socket.socket(fileno=copy)
    except OSError:
        os.close(copy)
        raise
    with one:
        yield one
