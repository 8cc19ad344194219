"""What a commander remembers across a restart of its process: the order in force."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from pathlib import Path

from hitab_agent import LineMemory

ORDERS_FILE = "orders.json"


@dataclass(frozen=True)
class Remembered:
    """What was in force when the process ended.

    Attributes:
        epoch: of that process; 0: there was none.
        behavior: the top-level behavior that the commander performed; empty: none.
        label: of the order; empty: none was given. The kind defines its meaning.
    """

    epoch: int = 0
    behavior: str = ""
    label: str = ""


class OrderMemory:
    """A small file in a commander's state folder; see `LineMemory`.

    If the file cannot be read, the commander starts without an order: its superior or a person
    will give one again.

    Attributes:
        remembered: what was in force.
        damage: why the file is ignored; empty if it is not.
    """

    def __init__(self, folder: Path) -> None:
        """Read the file.

        Args:
            folder: the folder of the file; it is created at the first write.
        """
        self._file = LineMemory(folder / ORDERS_FILE)
        self.damage = self._file.damage
        self.remembered = self._read()

    def _read(self) -> Remembered:
        said = self._file.values
        try:
            return Remembered(int(said["epoch"]), str(said["behavior"]), str(said["label"]))
        except (ArithmeticError, KeyError, TypeError, ValueError):
            return Remembered()

    def next_epoch(self) -> int:
        """Return a number larger than that of any earlier process, by the machine's clock."""
        return max(time.time_ns(), self.remembered.epoch + 1)

    def keep(self, remembered: Remembered) -> None:
        """Save what is in force now.

        Raises:
            OSError: if it cannot be written.
        """
        if remembered == self.remembered:
            return
        self.remembered = remembered
        self._file.write(asdict(remembered))
