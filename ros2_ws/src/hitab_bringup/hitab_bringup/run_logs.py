"""Reads the logs of a run: of its processes and of their supervisor, merged by time."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import BinaryIO, NamedTuple

from hitab_bringup.supervisor_log import in_plain_words
from hitab_client import RunFolder
from hitab_client.dds_profile import is_noise

SUPERVISOR = "supervisor"
READ_MAX = 1 << 19
"""Bytes that are read of a file that is not read whole."""

LEVELS = ("debug", "info", "warn", "error", "fatal")
"""The levels of a log, as ROS names them, the least severe first."""

_OF_ROS = re.compile(r"\[(\w+)\] \[(\d+\.\d+)\] \[([^\]]*)\]: (.*)")
_OF_SUPERVISOR = re.compile(r"(\d{4}-\d\d-\d\d \d\d:\d\d:\d\d),(\d{3}) (\w+) (.*)")
_FAILURE = re.compile(r"(Traceback|error:|Fatal Python error)")
"""Begins what a process prints past its logger when it fails."""


class Line(NamedTuple):
    """One line of a log.

    Attributes:
        seconds: when it was written, since the epoch; of a line without a time: that of the line
            before it.
        process: that wrote it.
        text: with the time readable.
        level: one of `LEVELS`; of a line without a level: that of the line before it, unless it
            begins a failure.
    """

    seconds: float
    process: str
    text: str
    level: str


@dataclass
class LogFile:
    """A log, which is read on from where the last reading ended."""

    process: str
    path: Path
    _offset: int = 0
    _inode: int = 0
    _partial: bytes = b""
    _seconds: float = 0.0
    _level: str = "info"

    def last(self, *, whole: bool = False, follow: bool = False) -> list[Line]:
        """Return the lines so far.

        Args:
            whole: all that are kept, not only the last ones.
            follow: leave a line that has not ended yet to `more`.
        """
        rotated = sorted(
            self.path.parent.glob(f"{self.path.name}.[0-9]*"),
            key=lambda path: int(path.suffix[1:]),
            reverse=True,
        )
        lines = []
        for path in rotated if whole else rotated[-1:]:
            with contextlib.suppress(OSError), path.open("rb") as file:
                lines += self._lines(_end_of(file, whole=whole))
        with contextlib.suppress(OSError), self.path.open("rb") as file:
            data = _end_of(file, whole=whole)
            self._offset, self._inode = file.tell(), os.fstat(file.fileno()).st_ino
            lines += self._ended_lines(data) if follow else self._lines(data)
        return lines

    def more(self) -> list[Line]:
        """Return the lines that were added since."""
        try:
            with self.path.open("rb") as file:
                status = os.fstat(file.fileno())
                if status.st_ino != self._inode or status.st_size < self._offset:
                    # The supervisor has begun a new file.
                    self._offset, self._inode, self._partial = 0, status.st_ino, b""
                file.seek(self._offset)
                data = file.read()
                self._offset = file.tell()
        except OSError:
            return []
        return self._ended_lines(data)

    def _ended_lines(self, data: bytes) -> list[Line]:
        ended, newline, self._partial = (self._partial + data).rpartition(b"\n")
        return self._lines(ended + newline)

    def _lines(self, data: bytes) -> list[Line]:
        found = []
        for line in data.decode(errors="replace").splitlines():
            if line and not is_noise(line) and (read := self._line(line)) is not None:
                found.append(read)
        return found

    def _line(self, line: str) -> Line | None:
        """Return a line as it is shown; None: it means nothing to a person."""
        if match := _OF_ROS.match(line):
            level, stamp, logger, text = match.groups()
            self._seconds = float(stamp)
            whose = logger.split(".")[0]
            text = text if whose == self.process else f"{whose}: {text}"
        elif match := _OF_SUPERVISOR.match(line):
            moment, milliseconds, level, text = match.groups()
            if (shown := in_plain_words(level, text)) is None:
                return None
            level, text = shown
            seconds = datetime.strptime(moment, "%Y-%m-%d %H:%M:%S").timestamp()
            self._seconds = seconds + int(milliseconds) / 1000
        else:
            if _FAILURE.match(line):
                self._level = "error"
            return Line(self._seconds, self.process, line, self._level)
        self._level = level.lower() if level.lower() in LEVELS else "info"
        text = f"{_readable(self._seconds)} {level:5} {text}"
        return Line(self._seconds, self.process, text, self._level)


def _end_of(file: BinaryIO, *, whole: bool) -> bytes:
    """Return the end of a file, from the beginning of a line on."""
    size = file.seek(0, os.SEEK_END)
    file.seek(0 if whole else max(0, size - READ_MAX))
    if file.tell():
        file.readline()
    return file.read()


def _readable(seconds: float) -> str:
    """Return a time in the local time zone, with milliseconds."""
    return datetime.fromtimestamp(seconds).isoformat(" ", "milliseconds")


def logs_of(folder: RunFolder) -> list[LogFile]:
    """Return the logs of a run folder: of the processes by name, and of the supervisor."""
    found = [LogFile(path.stem, path) for path in sorted((folder.path / "logs").glob("*.log"))]
    supervisor = folder.path / "supervisord.log"
    return [*found, LogFile(SUPERVISOR, supervisor)] if supervisor.exists() else found


def merged(logs: Iterable[Iterable[Line]]) -> list[Line]:
    """Return the lines of several logs in the order of their times."""
    return sorted((line for lines in logs for line in lines), key=lambda line: line.seconds)


def at_least(level: str, lines: Iterable[Line]) -> list[Line]:
    """Return the lines of a level, or a more severe one."""
    severe = LEVELS[LEVELS.index(level) :]
    return [line for line in lines if line.level in severe]


def shown(lines: Iterable[Line], *, names: bool) -> Iterator[str]:
    """Yield the lines as they are printed, each with its process if there are several."""
    for line in lines:
        yield f"{line.process} | {line.text}" if names else line.text
