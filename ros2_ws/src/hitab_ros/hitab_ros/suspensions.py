"""Detection of suspensions after which others may have dropped this process.

A participant that only one side has dropped is not fully rediscovered: if a heartbeat arrives
before the first request for earlier samples, Fast DDS 2.14 takes all of them for received.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable, Iterator
from xml.etree import ElementTree

DDS_PROFILE = "FASTRTPS_DEFAULT_PROFILES_FILE"
_LEASE_S = 20.0  # default of Fast DDS
_REMEMBERED = 0.8  # of the lease: the last announcement may be a fifth of it old


def remembered_s() -> float:
    """Return the time for which others remember a process that stands still, s."""
    try:
        root = ElementTree.parse(os.environ[DDS_PROFILE]).getroot()
        lease = float(root.findtext(".//{*}leaseDuration/{*}sec") or _LEASE_S)
    except (KeyError, OSError, ElementTree.ParseError, ValueError):
        lease = _LEASE_S
    return _REMEMBERED * lease


@contextlib.contextmanager
def suspensions_noticed(tell: Callable[[float], None]) -> Iterator[None]:
    """Call a function, in a thread, with the duration of each long suspension, s."""
    longest, over = remembered_s(), threading.Event()

    def watch() -> None:
        before = time.monotonic()
        while not over.wait(longest / 20.0):
            now = time.monotonic()
            if now - before > longest:
                tell(now - before)
            before = now

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
