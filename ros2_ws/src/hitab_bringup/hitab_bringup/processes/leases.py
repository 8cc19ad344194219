"""Leases of the processes on a machine: which machine runs a process is decided by the highest."""

from __future__ import annotations

import json
from pathlib import Path

from hitab_client import SwarmError
from hitab_core.library.durable_files import write_durably

LEASES = "leases.json"
FIRST_LEASE = 1
"""Lease of a process at its first start; each move to another machine adds 1."""


class Leases:
    """The leases in a run folder, by process.

    Args:
        folder: path of the run folder.
    """

    def __init__(self, folder: Path) -> None:
        self._file = folder / LEASES

    def of(self, process: str) -> int:
        """Return the lease of a process.

        Raises:
            SwarmError: if the file cannot be read.
        """
        return self._known().get(process, FIRST_LEASE)

    def set(self, process: str, lease: int) -> None:
        """Keep the lease of a process; it is on disk when this returns.

        Raises:
            SwarmError: if the file cannot be read.
        """
        text = json.dumps({**self._known(), process: lease}, indent=1) + "\n"
        write_durably(self._file, text.encode())

    def _known(self) -> dict[str, int]:
        try:
            known = json.loads(self._file.read_text(encoding="utf-8"))
            if not all(type(lease) is int and lease >= FIRST_LEASE for lease in known.values()):
                raise ValueError("a lease is a whole number from 1")
        except FileNotFoundError:
            return {}
        except (OSError, ValueError, AttributeError) as error:
            raise SwarmError(
                f"{self._file} cannot be read ({error}); remove it, and processes that were moved "
                "here run again where the swarm file says"
            ) from None
        return dict(known)
