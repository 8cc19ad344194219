"""Puts what the supervisor logs about processes into plain words."""

from __future__ import annotations

import re
from typing import NamedTuple


class _Saying(NamedTuple):
    """How a line of the supervisor is shown.

    Attributes:
        pattern: of the whole line.
        words: with the groups of the pattern; empty: the line means nothing to a person.
        level: as ROS names it; empty: the supervisor's own.
    """

    pattern: re.Pattern[str]
    words: str
    level: str = ""


_LEVELS = {"CRIT": "FATAL", "ERRO": "ERROR", "DEBG": "DEBUG", "TRAC": "DEBUG"}
"""The supervisor's names of levels that ROS names otherwise."""

_SAYINGS = tuple(
    _Saying(re.compile(pattern), *shown)
    for pattern, *shown in (
        # About a supervisor that others can reach; nobody else can open the folder of its socket.
        (r"Server 'unix_http_server' running without .*", ""),
        (r"Supervisor is running as root\..*", ""),
        (r"RPC interface '.*' initialized", ""),
        (r"reaped unknown pid .*", ""),
        (r"supervisord started with pid (\d+)", r"begins to supervise, as process \1"),
        (r"spawned: '(.*)' with pid (\d+)", r"started \1, process \2"),
        (r"spawnerr: (.*)", r"could not start a process: \1", "ERROR"),
        (r"success: (\S+) entered RUNNING state, .*", r"\1 keeps running"),
        (
            r"gave up: (\S+) entered FATAL state, .*",
            r"does not start \1 again: it ended each time",
            "ERROR",
        ),
        (r"exited: (\S+) \((.*); expected\)", r"\1 has ended (\2)"),
        (r"exited: (\S+) \((.*); not expected\)", r"\1 has ended unexpectedly (\2)"),
        (r"received SIGTERM indicating exit request", "ends the swarm", "INFO"),
        (r"waiting for (.*) to (?:die|stop)", r"waits until \1 have ended"),
        (r"stopped: (\S+) \((exit status 0)\)", r"\1 has ended (\2)", "INFO"),
        (r"stopped: (\S+) \((.*)\)", r"\1 has ended (\2)"),
        (r"killing '(.*)' \((\d+)\) with SIGKILL", r"kills \1 (process \2), which does not end"),
    )
)


def in_plain_words(level: str, text: str) -> tuple[str, str] | None:
    """Return the level and the text of a line of the supervisor as they are shown.

    Args:
        level: as the supervisor names it.
        text: after the level.

    Returns:
        The level as ROS names it, and the words; None: the line means nothing to a person. A line
        of an unknown kind stays as it is.

    Example:
        >>> in_plain_words("WARN", "exited: keeper_1 (terminated by SIGKILL; not expected)")
        ('WARN', 'keeper_1 has ended unexpectedly (terminated by SIGKILL)')
    """
    level = _LEVELS.get(level, level)
    for saying in _SAYINGS:
        if match := saying.pattern.fullmatch(text):
            return (saying.level or level, match.expand(saying.words)) if saying.words else None
    return level, text
