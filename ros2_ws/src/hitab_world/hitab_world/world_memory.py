"""What a world continues from after a restart of its process: its latest state and snapshots.

A thread replaces the latest state at a period, so that no cycle waits for a disk. What somebody
asks of the world is in the file before it is acknowledged. So is a snapshot that a person saves,
which stays until a person deletes it. The latest state is valid for one start of a swarm: the next
one starts as its description says.
"""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hitab_core import HitabError
from hitab_core.library.durable_files import UNFINISHED, file_errors, write_durably

LATEST = "latest.json"
NAMED = "snapshot-"
BYTES_MAX = 32_000_000
"""Larger states are not saved."""


class WorldMemory:
    """A folder with the latest state of a world and one file per saved snapshot."""

    def __init__(self, folder: Path, swarm: str, warn: Callable[[str], None]) -> None:
        """Use a folder, which is created with the first file.

        Args:
            folder: the folder of the files.
            swarm: identity of the world's swarm.
            warn: called once per file that is ignored or cannot be written; from any thread.
        """
        self._folder = folder
        self._swarm = swarm
        self._warn = warn
        self._warned: set[str] = set()
        self._next: bytes | None = None  # until it is written
        self._change = threading.Condition()
        self._closed = False
        self._writer: threading.Thread | None = None

    # -- the latest state -------------------------------------------------------------------

    def latest(self) -> dict[str, Any] | None:
        """Return the latest state saved by this swarm's world; None if there is none."""
        path = self._folder / LATEST
        saved = self._read(path)
        if saved is not None and saved.get("swarm") != self._swarm:
            path.unlink(missing_ok=True)  # of an earlier swarm, which will not return
            return None
        return saved

    def keep(self, state: Mapping[str, Any]) -> None:
        """Replace the latest state soon; one that has not been written yet is skipped.

        Args:
            state: JSON-able.

        Raises:
            HitabError: if it is too large.
            TypeError, ValueError: if it is not JSON-able.
        """
        data = self._encoded(state)
        with self._change:
            self._next = data
            if self._writer is None and not self._closed:
                self._writer = threading.Thread(target=self._write_states, daemon=True)
                self._writer.start()
            self._change.notify_all()

    def settle(self) -> None:
        """Wait until the state that was kept last is in its file, unless it cannot be written."""
        with self._change:
            self._change.wait_for(lambda: self._next is None or self._closed)

    def close(self) -> None:
        """Write the pending state, and stop."""
        with self._change:
            self._closed = True
            self._change.notify_all()
            writer = self._writer
        if writer is not None:
            writer.join()

    def _write_states(self) -> None:
        while True:
            with self._change:
                self._change.wait_for(lambda: self._next is not None or self._closed)
                data = self._next
            if data is None:
                return
            try:
                self._replace_latest(data)
            finally:
                with self._change:
                    if self._next is data:  # nothing newer has come
                        self._next = None
                    self._change.notify_all()

    def _replace_latest(self, data: bytes) -> None:
        path = self._folder / LATEST
        beside = path.with_suffix(UNFINISHED)
        try:
            # Readers see it whole or not at all; it need not survive a power failure.
            self._folder.mkdir(parents=True, exist_ok=True)
            beside.write_bytes(data)
            beside.replace(path)
        except OSError as error:
            self._say(f"a restart would not resume the world's latest state: {error}")

    # -- saved snapshots --------------------------------------------------------------------

    def named(self) -> dict[str, dict[str, Any]]:
        """Return the snapshots saved in this folder, by name, also at earlier starts."""
        found = {}
        for path in sorted(self._folder.glob(f"{NAMED}*.json")):
            saved = self._read(path)
            if saved is None:
                continue
            name, state = saved.get("name"), saved.get("state")
            if isinstance(name, str) and isinstance(state, dict):
                found[name] = state
            else:
                self._say(f"{path} is ignored: it is not a snapshot of a world")
        return found

    def save(self, name: str, state: Mapping[str, Any]) -> None:
        """Save a snapshot under a name; it is on disk when this returns.

        Raises:
            HitabError: if it cannot be written.
        """
        path = self._file(name)
        data = self._encoded({"name": name, "state": state})
        with file_errors(path, "write"):
            write_durably(path, data)

    def delete(self, name: str) -> None:
        """Delete a snapshot.

        Raises:
            HitabError: if its file cannot be removed.
        """
        path = self._file(name)
        with file_errors(path, "remove"):
            path.unlink(missing_ok=True)

    def _file(self, name: str) -> Path:
        return self._folder / f"{NAMED}{hashlib.sha256(name.encode()).hexdigest()[:16]}.json"

    # -- files ------------------------------------------------------------------------------

    def _read(self, path: Path) -> dict[str, Any] | None:
        try:
            if path.stat().st_size > BYTES_MAX:
                raise ValueError(f"it has more than {BYTES_MAX} bytes")
            values = json.loads(path.read_text(encoding="utf-8"))
            if not isinstance(values, dict):
                raise ValueError("it holds no fields")
        except FileNotFoundError:
            return None
        except (OSError, ValueError, RecursionError) as error:
            self._say(f"{path} is ignored because it cannot be read: {error}")
            return None
        return values

    def _encoded(self, values: Mapping[str, Any]) -> bytes:
        data = json.dumps({"swarm": self._swarm, **values}).encode()
        if len(data) > BYTES_MAX:
            raise HitabError(
                f"the world's state has {len(data)} bytes, more than the {BYTES_MAX} that can be "
                "saved for a restart"
            )
        return data

    def _say(self, text: str) -> None:
        if text not in self._warned:
            self._warned.add(text)
            self._warn(text)
