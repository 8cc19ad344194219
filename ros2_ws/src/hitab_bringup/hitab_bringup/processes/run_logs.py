"""Logs of a run: of its processes and of their supervisor, merged by time."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from hitab_client import RunFolder

SUPERVISOR = "supervisor"
LEVELS = ("debug", "info", "warn", "error", "fatal")
"""Levels of a log, as ROS names them, the least severe first."""

_OF_ROS = re.compile(r"\[(\w+)\] \[(\d+\.\d+)\] \[([^\]]*)\]: (.*)")
_OF_SUPERVISOR = re.compile(r"(\d{4}-\d\d-\d\d \d\d:\d\d:\d\d),(\d{3}) (\w+) (.*)")
_FAILURE = re.compile(r"(Traceback|error:|Fatal Python error)")
"""Prefixes of output that a failing process prints without its logger."""

_MEANINGLESS = re.compile(
    r"Server 'unix_http_server' running without|Supervisor is running as root"
)
"""Log lines that matter only for a supervisor with a public socket."""

_GIVES_UP = re.compile(r"gave up|spawnerr")
"""Prefixes of errors that the supervisor does not log as errors."""


class LogLine(NamedTuple):
    """A line of a log.

    Attributes:
        seconds: time of writing, s since the epoch; for a line without a time, the time of the
            line before.
        process: name of the process that wrote the line.
        text: the line with a readable time.
        level: one of `LEVELS`; for a line without a level, the level of the line before, unless
            the line begins a failure.
    """

    seconds: float
    process: str
    text: str
    level: str


@dataclass
class LogFile:
    """A log file; each reading continues where the last one ended."""

    process: str
    path: Path
    _offset: int = 0
    _inode: int = 0
    _seconds: float = 0.0
    _level: str = "info"

    def new(self, *, ended: bool) -> list[LogLine]:
        """Return the lines since the last call; ``ended`` leaves an incomplete line for later."""
        lines = []
        for path in self._rotated() if not self._inode else ():
            with contextlib.suppress(OSError):
                lines += self._lines(path.read_bytes())
        try:
            with self.path.open("rb") as file:
                inode = os.fstat(file.fileno()).st_ino
                if inode != self._inode:  # the supervisor has started a new file
                    self._offset, self._inode = 0, inode
                file.seek(self._offset)
                data = file.read()
        except OSError:
            return lines
        if ended:
            data = data[: data.rfind(b"\n") + 1]
        self._offset += len(data)
        return lines + self._lines(data)

    def parsed(self, lines: Iterable[str], level: str) -> list[LogLine]:
        """Return lines of the log that were read elsewhere, of this level or above."""
        found = self._lines("\n".join(lines).encode())
        return [line for line in found if LEVELS.index(line.level) >= LEVELS.index(level)]

    def _rotated(self) -> list[Path]:
        earlier = self.path.parent.glob(f"{self.path.name}.[0-9]*")
        return sorted(earlier, key=lambda path: int(path.suffix[1:]), reverse=True)

    def _lines(self, data: bytes) -> list[LogLine]:
        lines = data.decode(errors="replace").splitlines()
        return [self._line(line) for line in lines if line and not _MEANINGLESS.search(line)]

    def _line(self, line: str) -> LogLine:
        if match := _OF_ROS.match(line):
            level, stamp, logger, text = match.groups()
            self._seconds = float(stamp)
            whose = logger.split(".")[0]
            text = text if whose == self.process else f"{whose}: {text}"
        elif match := _OF_SUPERVISOR.match(line):
            moment, milliseconds, level, text = match.groups()
            level = "ERROR" if level == "ERRO" or _GIVES_UP.match(text) else level
            seconds = datetime.strptime(moment, "%Y-%m-%d %H:%M:%S").timestamp()
            self._seconds = seconds + int(milliseconds) / 1000
        else:
            if _FAILURE.match(line):
                self._level = "error"
            return LogLine(self._seconds, self.process, line, self._level)
        self._level = level.lower() if level.lower() in LEVELS else "info"
        moment = datetime.fromtimestamp(self._seconds).isoformat(" ", "milliseconds")
        return LogLine(self._seconds, self.process, f"{moment} {level:5} {text}", self._level)


def logs_of(folder: RunFolder) -> list[LogFile]:
    """Return the logs of a run folder: of the processes by name, and of the supervisor."""
    found = [LogFile(path.stem, path) for path in sorted((folder.path / "logs").glob("*.log"))]
    supervisor = folder.path / "supervisord.log"
    return [*found, LogFile(SUPERVISOR, supervisor)] if supervisor.exists() else found


def new_lines(files: Iterable[LogFile], level: str, *, ended: bool) -> list[LogLine]:
    """Return the new lines of several logs in the order of their times.

    Args:
        files: the logs.
        level: level of the least severe lines.
        ended: whether to leave incomplete lines for later.
    """
    severe = LEVELS[LEVELS.index(level) :]
    lines = (line for file in files for line in file.new(ended=ended) if line.level in severe)
    return sorted(lines, key=lambda line: line.seconds)
