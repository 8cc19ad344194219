"""Deferral of Ctrl-C, SIGTERM and SIGHUP while a change must not be left half done."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import traceback
from collections.abc import Iterator
from types import FrameType

from hitab_ros.timing import TURN_S

_came: list[int] = []
_depth = 0

FROM_C = "pymunk._callbacks"
"""Module whose functions are called from C, where an exception would be lost."""


def handle_interruptions() -> None:
    """Install the handlers of Ctrl-C, SIGTERM and SIGHUP in this process; deferring is then cheap.

    Ctrl-C raises KeyboardInterrupt. SIGTERM, and SIGHUP of a closed terminal, raise SystemExit
    with the usual status. Signals that this process was started to ignore, as by ``nohup``, stay
    ignored.
    """
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _interrupt)


def forget_handled() -> None:
    """Let this process end with its own exit status, even after a handled Ctrl-C.

    Python remembers a KeyboardInterrupt that interrupted an executed string, and then ends by
    SIGINT even if the interrupt was handled. Dataclass definitions execute strings, and many are
    defined while a command starts. Executing another string resets this.
    """
    exec("")


@contextlib.contextmanager
def not_interrupted() -> Iterator[None]:
    """Defer Ctrl-C, SIGTERM or SIGHUP to the end of the context, after `handle_interruptions`.

    Outside the main thread, do nothing.
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
        threading.Timer(TURN_S, os.kill, (os.getpid(), number)).start()
    elif number == signal.SIGINT:
        raise KeyboardInterrupt
    else:
        sys.exit(128 + number)
