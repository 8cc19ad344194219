"""Defers Ctrl-C, SIGTERM and SIGHUP where half of something must not be left."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import traceback
from collections.abc import Iterator
from types import FrameType

_came: list[int] = []
_depth = 0

FROM_C = "pymunk._callbacks"
"""Module of functions that are called from C, where an exception would be lost."""

SIGNAL_REPEAT_S = 0.01
"""Delay after which a signal that came in such a function is raised again, s."""


def handle_interruptions() -> None:
    """Handle these signals in this process from now on, so that deferring them costs nothing.

    Ctrl-C raises KeyboardInterrupt. SIGTERM, and SIGHUP of a terminal that is closed, raise
    SystemExit with the usual status. What this process was started to ignore, as by ``nohup``,
    stays ignored.
    """
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _interrupt)


def forget_handled() -> None:
    """Have this process end with its exit status, whatever Ctrl-C interrupted before.

    Python remembers a KeyboardInterrupt that left a string which was being executed, and ends by
    SIGINT then, even if it was handled. Each definition of a dataclass executes strings, and many
    are defined while a command begins. What is executed next resets that.
    """
    exec("")


@contextlib.contextmanager
def not_interrupted() -> Iterator[None]:
    """Defer the first of these signals to the end, where `handle_interruptions` was called.

    Do nothing outside the main thread.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    global _depth
    _depth += 1
    try:
        yield
    finally:
        _depth -= 1
        if _came and not _depth:
            _interrupt(_came.pop(), None)


def _interrupt(number: int, frame: FrameType | None) -> None:
    if _depth and not _came:
        _came.append(number)
    elif any(f.f_globals.get("__name__") == FROM_C for f, _ in traceback.walk_stack(frame)):
        threading.Timer(SIGNAL_REPEAT_S, os.kill, (os.getpid(), number)).start()
    elif number == signal.SIGINT:
        raise KeyboardInterrupt
    else:
        sys.exit(128 + number)
