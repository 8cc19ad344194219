"""Small files that survive a process, but need not survive the machine."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any


class LineMemory:
    """A file whose first line is what counts.

    Writing must not hold anything up: a line is written over the one before in one go, which takes
    microseconds, and what is longer stays behind it.

    Attributes:
        values: what the file holds; empty if there is none, or it is damaged.
        damage: why it cannot be read, and that it is ignored; empty if it can.
    """

    def __init__(self, path: Path) -> None:
        """Read it.

        Args:
            path: of the file; it is made, with its folder, when there is something to remember.
        """
        self._path = path
        self.values: dict[str, Any] = {}
        self.damage = ""
        try:
            with path.open(encoding="utf-8") as file:
                values = json.loads(file.readline())
            if not isinstance(values, dict):
                raise ValueError("it holds no fields")
            self.values = values
        except FileNotFoundError:
            pass
        except (OSError, ValueError) as error:
            self.damage = f"{path} is ignored, since it cannot be read: {error}"

    def write(self, values: Mapping[str, Any]) -> None:
        """Replace what the file holds.

        Raises:
            OSError: if it cannot be written.
        """
        line = json.dumps(values) + "\n"
        try:
            file = os.open(self._path, os.O_WRONLY | os.O_CREAT, 0o644)
        except FileNotFoundError:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            file = os.open(self._path, os.O_WRONLY | os.O_CREAT, 0o644)
        try:
            os.write(file, line.encode())
        finally:
            os.close(file)
        self.values = dict(values)
