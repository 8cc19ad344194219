"""The memory of an agent's process, for the process that takes its place after a kill."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

FOLDER = "restart"
"""Folder of the files of all agents with a state folder: a thousand folders take a second more."""


class RestartMemory:
    """A small file of an agent; it need not survive a power failure.

    Writing must be fast: a line overwrites the previous one in a single call, which takes
    microseconds. Only the first line is read; the rest of a longer previous line stays behind it.

    Attributes:
        values: the notes by name; at first those of the process before this one.
        performed: the top-level behavior of the process before this one, empty if there was none;
            None if this is the agent's first start in its swarm. An agent outside any swarm is
            started by a person, who chooses its behavior.
        trained: whether a demonstrator trained the agent, so that a training goes on; the first
            start in a swarm goes on with any.
        damage: why the file is ignored; empty if it can be read.
    """

    def __init__(self, state_dir: Path, agent: str, swarm: str) -> None:
        """Read the file.

        Args:
            state_dir: the folder of all agents' state.
            agent: the agent's name.
            swarm: identity of the agent's swarm; empty if none.
        """
        self._path = state_dir / FOLDER / f"{agent}.json"
        self._swarm = swarm
        self.values: dict[str, Any] = {}
        self.performed: str | None = None
        self.trained = True
        self.damage = ""
        try:
            with self._path.open(encoding="utf-8") as file:
                self.values = dict(json.loads(file.readline()))
        except FileNotFoundError:
            pass
        except (OSError, TypeError, ValueError) as error:
            self.damage = f"{self._path} is ignored because it cannot be read: {error}"
        if swarm and self.values.get("swarm") == swarm:
            self.performed = str(self.values.get("behavior", ""))
            self.trained = bool(self.values.get("trained", True))

    def keep(self, values: Mapping[str, Any]) -> None:
        """Note values, if that changes anything.

        Raises:
            OSError: if they cannot be written.
        """
        noted = {**self.values, **values, "swarm": self._swarm}
        if noted == self.values:
            return
        flags = os.O_WRONLY | os.O_CREAT
        try:
            file = os.open(self._path, flags, 0o644)
        except FileNotFoundError:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            file = os.open(self._path, flags, 0o644)
        try:
            os.write(file, json.dumps(noted).encode() + b"\n")
        finally:
            os.close(file)
        self.values = noted
