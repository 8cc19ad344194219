"""Keeps a world's state at a period, and goes on from it after a restart of the process."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hitab_ros import names
from hitab_world.settings import check_factor, check_pace
from hitab_world.world import LiveWorld
from hitab_world.world_memory import WorldMemory

if TYPE_CHECKING:
    from hitab_world.world_node import WorldNode

LEISURE = 50
"""Times as long as a snapshot took until the next one is taken, at least."""

_CONTROL: dict[str, type] = {
    "pace": str,
    "factor": float,
    "paused": bool,
    "steps_left": int,
    "episodes_left": int,
}


class WorldKeeper:
    """The memory of a world's node.

    A world that is part of no swarm, or that goes on by itself, such as a server elsewhere, has
    none. So the state is kept by a swarm's identity; see `WorldMemory`.

    Attributes:
        named: snapshots that were saved, by name.
    """

    def __init__(self, node: WorldNode) -> None:
        self._node = node
        self.named: dict[str, dict[str, Any]] = {}
        self._memory: WorldMemory | None = None
        self._kept: tuple[Any, ...] = ()
        self._touched = False
        self._next_s = self._earliest_s = 0.0
        settings = node.settings
        wanted = settings.swarm and settings.state_dir and settings.snapshot_period
        if wanted and not isinstance(node.world, LiveWorld):
            folder = Path(settings.state_dir).expanduser() / names.own_name(node)
            self._memory = WorldMemory(folder, settings.swarm, node.get_logger().warning)

    def restore(self) -> bool:
        """Go on where the process before this one ended; return whether there was one."""
        if self._memory is None:
            return False
        self.named = self._memory.named()
        latest = self._memory.latest()
        if latest is None:
            return False
        node = self._node
        try:
            control = dict(_control(latest["control"]))
            node.world.restore(latest["world"])
        except Exception as error:  # a world's restore is anybody's code
            node.get_logger().warning(
                f"the world begins anew, since its latest state cannot be restored: {error!r}"
            )
            return False
        for name, value in control.items():
            setattr(node, name, value)
        return True

    def touch(self) -> None:
        """Keep the state soon, since it was changed from outside."""
        self._touched = True

    def attend(self) -> None:
        """Keep the state if it is time to and it has changed; called between cycles."""
        if self._memory is None:
            return
        now = time.monotonic()
        if now >= self._earliest_s and (self._touched or now >= self._next_s):
            self._keep(now)

    def _keep(self, now: float) -> None:
        assert self._memory is not None
        node = self._node
        control = {name: getattr(node, name) for name in _CONTROL}
        state = (node.world.cycle, *control.values())
        self._next_s = now + node.settings.snapshot_period
        if state == self._kept and not self._touched:
            return
        self._kept, self._touched = state, False
        try:
            self._memory.keep({"control": control, "world": node.world.snapshot()})
        except Exception as error:  # a world's snapshot is anybody's code
            self._memory = None
            node.get_logger().warning(
                f"a restart of the world would begin anew, since its state cannot be kept: "
                f"{error!r}"
            )
        self._earliest_s = now + LEISURE * (time.monotonic() - now)

    def save(self, name: str, state: dict[str, Any]) -> None:
        """Keep a snapshot under a name.

        Raises:
            HitabError: if it cannot be written; then it is not kept at all.
        """
        if self._memory is not None:
            self._memory.save(name, state)
        self.named[name] = state

    def delete(self, name: str) -> None:
        """Forget a snapshot.

        Raises:
            HitabError: if its file cannot be removed.
        """
        if self._memory is not None:
            self._memory.delete(name)
        del self.named[name]

    def close(self) -> None:
        """Keep the state as it is at the end."""
        if self._memory is not None:
            self._keep(time.monotonic())
        if self._memory is not None:
            self._memory.close()


def _control(values: Any) -> Iterator[tuple[str, Any]]:
    """Yield how the world was run, if it can be run so.

    Raises:
        HitabError, LookupError, TypeError, ValueError: if it cannot.
    """
    for name, kind in _CONTROL.items():
        value = values[name]
        if type(value) is not kind:
            raise TypeError(f"{name} is {value!r}")
        if isinstance(value, int) and value < 0:
            raise ValueError(f"{name} is {value!r}")
        yield name, value
    check_pace(values["pace"])
    check_factor(values["factor"])
