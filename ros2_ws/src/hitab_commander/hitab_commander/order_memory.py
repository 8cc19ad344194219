"""What a commander remembers across a restart of its process: the order in force."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

FILE_NAME = "orders.json"


@dataclass(frozen=True)
class Remembered:
    """What was in force when the process ended.

    Attributes:
        epoch: of that process; 0: there was none.
        behavior: the top-level behavior that the commander performed; empty: none.
        label: of the order; empty: none was given.
        behaviors: what it had the subordinates perform, by receiver.
    """

    epoch: int = 0
    behavior: str = ""
    label: str = ""
    behaviors: Mapping[str, str] = field(default_factory=dict)


def _now(do: Callable[[], None]) -> None:
    do()


class OrderMemory:
    """A small file in a commander's state folder.

    It is as good as its last line: what cannot be read is taken for a commander that has ordered
    nothing yet, since its superior or a person will order again.
    """

    def __init__(self, folder: Path, aside: Callable[[Callable[[], None]], object] = _now) -> None:
        """Read it.

        Args:
            folder: where the file is.
            aside: does the writing; one after the other, but perhaps not at once.
        """
        self._path = folder / FILE_NAME
        self._aside = aside
        self.remembered = self._read()

    def _read(self) -> Remembered:
        try:
            said = json.loads(self._path.read_text(encoding="utf-8"))
            return Remembered(
                int(said["epoch"]),
                str(said["behavior"]),
                str(said["label"]),
                {str(receiver): str(what) for receiver, what in said["behaviors"].items()},
            )
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return Remembered()

    def next_epoch(self) -> int:
        """Return a number larger than that of any process before, by the machine's clock."""
        return max(time.time_ns(), self.remembered.epoch + 1)

    def keep(self, remembered: Remembered) -> None:
        """Write down what is in force now.

        It has to survive the process, not the machine: an order must not wait for a disk.
        """
        if remembered == self.remembered:
            return
        self.remembered = remembered
        self._aside(lambda: self._write(remembered))

    def _write(self, remembered: Remembered) -> None:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        beside = self._path.with_suffix(".partial")
        beside.write_text(json.dumps(asdict(remembered)) + "\n", encoding="utf-8")
        os.replace(beside, self._path)
