"""Small files that survive a restart of the process, but need not survive a power failure."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any


class LineMemory:
    """A file of which only the first line is read.

    Writing must be fast: a line overwrites the previous one in a single call, which takes
    microseconds; the rest of a longer previous line stays behind it.

    Attributes:
        values: what the file holds; empty if it is missing or damaged.
        damage: why the file is ignored; empty if it can be read.
    """

    def __init__(self, path: Path) -> None:
        """Read the file.

        Args:
            path: of the file; it is created, with its folder, at the first write.
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
            self.damage = f"{path} is ignored because it cannot be read: {error}"

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
