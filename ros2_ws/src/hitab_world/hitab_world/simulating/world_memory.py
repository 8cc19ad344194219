"""The memory of a world: snapshots, and the latest state for a restarted process.

The latest state is saved periodically, and after each request that changes the world, before the
request is acknowledged. The state is valid for one start of a swarm: the next start follows the
swarm file, but a paused world stays paused. Snapshots stay until a person deletes them.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from hitab_core.library.durable_files import UNFINISHED, file_errors, write_durably
from hitab_world.node.settings import WorldSettings
from hitab_world.simulating.control import Control
from hitab_world.simulating.run_state import RunState
from hitab_world.world import LiveWorld

LATEST_FILE = "latest.json"
NAMED = "snapshot-"
SAVE_INTERVAL_FACTOR = 50
"""Minimum time between two saved states, as a multiple of the time that saving takes."""


class WorldMemory:
    """A folder with the latest state of a world and one file per saved snapshot.

    A world outside any swarm, or one that runs by itself on another server, is not saved.

    Attributes:
        named: the saved snapshots, by name, also of earlier starts.
    """

    def __init__(
        self,
        name: str,
        run_state: RunState,
        settings: WorldSettings,
        warn: Callable[[str], None],
        unsaved: Callable[[str], object],
    ) -> None:
        """Locate the files of the previous process, if there are any.

        Args:
            name: name of the world and its folder, which is created with the first file.
            run_state: the state to save.
            settings: the world's parameters: folder, period and swarm.
            warn: called with a warning about a file that cannot be restored.
            unsaved: called with the reason why the state cannot be saved, and with "" once it can.
        """
        self.named: dict[str, dict[str, Any]] = {}
        self._run_state, self._warn, self._unsaved = run_state, warn, unsaved
        self._swarm, self._period = settings.swarm, settings.snapshot_period
        self._saved: tuple[Any, ...] = ()
        self._next_s = self._earliest_s = 0.0
        self._folder: Path | None = None
        wanted = settings.swarm and settings.state_dir and settings.snapshot_period
        if wanted and not isinstance(run_state.world, LiveWorld):
            self._folder = Path(settings.state_dir).expanduser() / name

    def restore(self) -> bool:
        """Restore the previous process's state; return whether there was one."""
        if self._folder is None:
            return False
        for path in sorted(self._folder.glob(f"{NAMED}*.json")):
            self._read(path, lambda saved: self.named.update({saved["name"]: {**saved["state"]}}))
        return bool(self._read(self._folder / LATEST_FILE, self._take_over))

    def _take_over(self, latest: dict[str, Any]) -> bool:
        if latest["swarm"] != self._swarm:
            # The state is from an earlier start of the swarm. Keep its pause, which only a person
            # ends.
            self._run_state.control.paused |= latest["control"]["paused"] is True
            return False
        control = Control.read(latest["control"])
        self._run_state.world.restore(latest["world"])
        self._run_state.control.take_over(control)
        return True

    def _read(self, path: Path, take: Callable[[dict[str, Any]], Any]) -> Any:
        """Pass the contents of a file on; warn about a file that cannot be used, and ignore it."""
        try:
            return take(json.loads(path.read_text(encoding="utf-8")))
        except FileNotFoundError:
            return None
        except Exception as error:  # a world's restore may be third-party code
            self._warn(f"{path} is ignored because it cannot be restored: {error!r}")
            return None

    def save_if_due(self) -> None:
        """Save the state if that is due and the state has changed; called between cycles."""
        now = time.monotonic()
        if now >= self._earliest_s and (self._run_state.touched or now >= self._next_s):
            self.save_latest()

    def save_now(self) -> None:
        """Save the state after a request's change, before the request is acknowledged."""
        if self._run_state.touched:
            self.save_latest()

    def save_latest(self) -> None:
        """Save the state if it has changed."""
        if self._folder is None:
            return
        run_state, now = self._run_state, time.monotonic()
        control = asdict(run_state.control)
        state = (run_state.world.cycle, *control.values())
        self._next_s = now + self._period
        if state == self._saved and not run_state.touched:
            return
        run_state.touched = False
        path = self._folder / LATEST_FILE
        beside = path.with_suffix(UNFINISHED)
        try:
            saved = {"swarm": self._swarm, "control": control, "world": run_state.world.snapshot()}
            self._folder.mkdir(parents=True, exist_ok=True)
            # Readers see a whole file or none; the file need not survive a power failure.
            beside.write_text(json.dumps(saved), encoding="utf-8")
            beside.replace(path)
            self._saved = state
            self._unsaved("")
        except Exception as error:  # a world's snapshot may be third-party code
            why = error.strerror if isinstance(error, OSError) else repr(error)
            back = f"go back to cycle {self._saved[0]}" if self._saved else "start over"
            self._unsaved(
                f"its state cannot be saved to {path} ({why}): if its process restarts, it will "
                f"{back}"
            )
        self._earliest_s = now + SAVE_INTERVAL_FACTOR * (time.monotonic() - now)

    def save(self, name: str, state: dict[str, Any]) -> None:
        """Save a snapshot under a name; it is on disk when this returns.

        Raises:
            HitabError: if the snapshot cannot be written; nothing is saved then.
        """
        if self._folder is not None:
            path = self._file(self._folder, name)
            data = json.dumps({"swarm": self._swarm, "name": name, "state": state}).encode()
            with file_errors(path, "write"):
                write_durably(path, data)
        self.named[name] = state

    def delete(self, name: str) -> None:
        """Delete a snapshot.

        Raises:
            HitabError: if its file cannot be removed.
        """
        if self._folder is not None:
            path = self._file(self._folder, name)
            with file_errors(path, "remove"):
                path.unlink(missing_ok=True)
        del self.named[name]

    @staticmethod
    def _file(folder: Path, name: str) -> Path:
        return folder / f"{NAMED}{hashlib.sha256(name.encode()).hexdigest()[:16]}.json"
