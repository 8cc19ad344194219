"""What a commander remembers across a restart of its process: the order in force."""

from __future__ import annotations

import json
import os
import time
from dataclasses import asdict, dataclass
from pathlib import Path

FILE_NAME = "orders.json"


@dataclass(frozen=True)
class Remembered:
    """What was in force when the process ended.

    Attributes:
        epoch: of that process; 0: there was none.
        behavior: the top-level behavior that the commander performed; empty: none.
        label: of the order; empty: none was given. What it means is told by the kind.
    """

    epoch: int = 0
    behavior: str = ""
    label: str = ""


class OrderMemory:
    """A small file in a commander's state folder; its first line is what counts.

    It has to survive the process, not the machine, and an order must not wait for it: a line is
    written over the one before in one go, which takes microseconds, and what is longer stays
    behind it. What cannot be read is taken for a commander that has ordered nothing yet, since its
    superior or a person will order again.
    """

    def __init__(self, folder: Path) -> None:
        """Read it.

        Args:
            folder: where the file is; it is made when there is something to remember.
        """
        self._path = folder / FILE_NAME
        self.remembered = self._read()

    def _read(self) -> Remembered:
        try:
            with self._path.open(encoding="utf-8") as file:
                said = json.loads(file.readline())
            return Remembered(int(said["epoch"]), str(said["behavior"]), str(said["label"]))
        except (OSError, ValueError, KeyError, TypeError):
            return Remembered()

    def next_epoch(self) -> int:
        """Return a number larger than that of any process before, by the machine's clock."""
        return max(time.time_ns(), self.remembered.epoch + 1)

    def keep(self, remembered: Remembered) -> None:
        """Write down what is in force now."""
        if remembered == self.remembered:
            return
        self.remembered = remembered
        line = json.dumps(asdict(remembered)) + "\n"
        try:
            file = os.open(self._path, os.O_WRONLY | os.O_CREAT, 0o644)
        except FileNotFoundError:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            file = os.open(self._path, os.O_WRONLY | os.O_CREAT, 0o644)
        try:
            os.write(file, line.encode())
        finally:
            os.close(file)
