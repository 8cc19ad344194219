"""Keeps messages of Fast DDS that only frighten away from the user.

HiTAB's own DDS profiles give no cause for them; see `is_noise`. With a profile of the user's own
the library prints them to the standard error of the process, past Python.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Iterator, Mapping

from hitab_client.dds_profile import is_noise, is_users_own

STDERR = 2
END_SECONDS = 1.0  # for the last lines; a process that was started meanwhile may hold the pipe


@contextlib.contextmanager
def noise_left_out(environment: Mapping[str, str] = os.environ) -> Iterator[None]:
    """Leave such messages out of the standard error for the duration of the context.

    Python's own messages go past the filter, so that they know whether they go to a terminal.
    """
    if not is_users_own(environment):
        yield
        return
    real = os.dup(STDERR)
    reading, writing = os.pipe()
    python_own, sys.stderr = sys.stderr, os.fdopen(os.dup(real), "w", buffering=1)
    os.dup2(writing, STDERR)
    os.close(writing)
    filtering = threading.Thread(target=_pass_on, args=(reading, real), daemon=True)
    filtering.start()
    try:
        yield
    finally:
        sys.stderr.flush()
        sys.stderr = python_own
        os.dup2(real, STDERR)  # closes the pipe
        filtering.join(END_SECONDS)


def _pass_on(reading: int, real: int) -> None:
    with os.fdopen(reading, "rb") as lines:
        for line in lines:
            if not is_noise(line.decode(errors="replace")):
                os.write(real, line)
