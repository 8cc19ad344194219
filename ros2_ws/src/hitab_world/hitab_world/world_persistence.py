"""Saves a world's state at a period, and continues from it after a restart of the process."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from hitab_world.control import Control
from hitab_world.course import Course
from hitab_world.settings import WorldSettings
from hitab_world.world import LiveWorld
from hitab_world.world_memory import WorldMemory

LEISURE = 50
"""Minimum time between two snapshots, as a multiple of the time that one takes."""


class WorldPersistence:
    """The memory of a world's course.

    The state is saved for the swarm with its identity; see `WorldMemory`. Nothing is saved for a
    world outside any swarm or one that runs by itself, such as on a server elsewhere.

    Attributes:
        named: the saved snapshots, by name.
    """

    def __init__(
        self, name: str, course: Course, settings: WorldSettings, warn: Callable[[str], None]
    ) -> None:
        """Locate the files of the previous process, if there are any.

        Args:
            name: of the world and its folder.
            course: what to save.
            settings: where, how often, and for which swarm.
            warn: logs what cannot be saved or restored.
        """
        self._course = course
        self._warn = warn
        self._period = settings.snapshot_period
        self.named: dict[str, dict[str, Any]] = {}
        self._memory: WorldMemory | None = None
        self._kept: tuple[Any, ...] = ()
        self._next_s = self._earliest_s = 0.0
        wanted = settings.swarm and settings.state_dir and settings.snapshot_period
        if wanted and not isinstance(course.world, LiveWorld):
            folder = Path(settings.state_dir).expanduser() / name
            self._memory = WorldMemory(folder, settings.swarm, warn)

    def restore(self) -> bool:
        """Continue where the previous process ended; return whether there was one."""
        if self._memory is None:
            return False
        self.named = self._memory.named()
        latest = self._memory.latest()
        if latest is None:
            return False
        course = self._course
        try:
            control = Control.read(latest["control"])
            course.world.restore(latest["world"])
        except Exception as error:  # a world's restore may be third-party code
            self._warn(
                f"the world starts over because its latest state cannot be restored: {error!r}"
            )
            return False
        course.control.take_over(control)
        return True

    def save_if_due(self) -> None:
        """Save the state if it is due and has changed; called between cycles."""
        if self._memory is None:
            return
        now = time.monotonic()
        if now >= self._earliest_s and (self._course.touched or now >= self._next_s):
            self._keep(now)

    def save_now(self) -> None:
        """Save what a request has changed, and wait until it is saved: then acknowledge it."""
        if self._memory is not None and self._course.touched:
            self._keep(time.monotonic())
        if self._memory is not None:
            self._memory.settle()

    def _keep(self, now: float) -> None:
        assert self._memory is not None
        course = self._course
        control = asdict(course.control)
        state = (course.world.cycle, *control.values())
        self._next_s = now + self._period
        if state == self._kept and not course.touched:
            return
        self._kept, course.touched = state, False
        try:
            self._memory.keep({"control": control, "world": course.world.snapshot()})
        except Exception as error:  # a world's snapshot may be third-party code
            self._memory = None
            self._warn(
                f"a restarted world would start over because its state cannot be saved: {error!r}"
            )
        self._earliest_s = now + LEISURE * (time.monotonic() - now)

    def save(self, name: str, state: dict[str, Any]) -> None:
        """Save a snapshot under a name.

        Raises:
            HitabError: if it cannot be written; then it is not saved at all.
        """
        if self._memory is not None:
            self._memory.save(name, state)
        self.named[name] = state

    def delete(self, name: str) -> None:
        """Delete a snapshot.

        Raises:
            HitabError: if its file cannot be removed.
        """
        if self._memory is not None:
            self._memory.delete(name)
        del self.named[name]

    def close(self) -> None:
        """Save the final state."""
        if self._memory is not None:
            self._keep(time.monotonic())
        if self._memory is not None:
            self._memory.close()
