"""A disk on which any operation can be made to fail, for tests of what is left then."""

import errno
import fcntl
import io
import os
import resource
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

CHANGING = ("write", "fsync", "replace", "rename", "unlink", "mkdir", "rmdir", "ftruncate")
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT


@contextmanager
def files_end_at(size: int) -> Iterator[None]:
    """Cut off what this process writes behind so many bytes of any file, and fail."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


class Killed(BaseException):
    """The process ends here."""


class Statements(sqlite3.Connection):
    """A database of which any statement can be made to fail; see `use_statements`."""

    def before(self, statement: str) -> None:
        """Do nothing; a `FaultyDisk` replaces it."""

    def execute(self, statement: str, *args: Any) -> sqlite3.Cursor:
        self.before(statement)
        return super().execute(statement.replace("= FULL", "= OFF"), *args)


def use_statements(patch: pytest.MonkeyPatch) -> None:
    """Have databases that are opened from now on be `Statements`, without power failures."""
    connect = sqlite3.connect
    patch.setattr(sqlite3, "connect", lambda *a, **k: connect(*a, **k, factory=Statements))


class FaultyDisk:
    """Counts operations on files, and has one of them fail.

    Attributes:
        count: operations so far.
    """

    def __init__(self, patch: pytest.MonkeyPatch, folder: Path, fails_at: int, how: str) -> None:
        """Replace the operations.

        Args:
            patch: with which to replace them.
            folder: what is outside of it works as ever.
            fails_at: which operation fails, from 1.
            how: "once"; "full": all that change anything fail from then on; "killed": the process
                ends there, and nothing is done any more.
        """
        self.count = 0
        self._folder = folder
        self._at = fails_at
        self._how = how
        for name in CHANGING:
            patch.setattr(os, name, self._faulty(getattr(os, name), lambda *a, **k: True))
        opened = os.open
        patch.setattr(os, "open", self._faulty(opened, lambda p, f, *a, **k: bool(f & WRITING)))
        for module, name in ((io, "open"), (fcntl, "flock")):
            patch.setattr(module, name, self._faulty(getattr(module, name), lambda *a, **k: False))
        patch.setattr(Statements, "before", self._faulty(Statements.before, lambda *a: True))

    @property
    def failed(self) -> bool:
        """Whether the operation that fails was reached."""
        return self.count >= self._at

    def _faulty(self, real: Any, changes: Any) -> Any:
        def operation(*args: Any, **more: Any) -> Any:
            if isinstance(args[0], str | Path) and self._folder not in Path(args[0]).parents:
                return real(*args, **more)
            self.count += 1
            if self._how == "killed" and self.failed:
                raise Killed
            if self._how == "full" and self.failed and changes(*args, **more):
                raise OSError(errno.ENOSPC, "No space left on device")
            if self.count == self._at:
                raise OSError(errno.EIO, "Input/output error")
            return real(*args, **more)

        return operation
