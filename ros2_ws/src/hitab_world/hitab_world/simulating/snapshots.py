"""The common header of all worlds' snapshots: the world, and the time of the snapshot.

A world's `World.snapshot` returns `header` and, under further keys, its own state. Its `restore`
reads them within `reading`, which refuses a snapshot that is damaged or of another world::

    def restore(self, snapshot):
        with reading(snapshot, self, VERSION) as moment:
            leaves = [float(x) for x in snapshot["leaves"]]
        # Nothing has changed until here, and nothing can fail from here on.
        moment.bring_back(self)
        self.leaves = leaves
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from typing import Any, Protocol

from hitab_core import some
from hitab_world.parameters import Parameters
from hitab_world.world import World, WorldError


class ParameterizedWorld(World, Protocol):
    """A world whose state depends on its parameters."""

    @property
    def parameters(self) -> Parameters:
        """The parameters of the world."""


@dataclass(frozen=True, slots=True)
class SnapshotHeader:
    """The header of a snapshot: the world's counts when it was taken, as in `World`."""

    seed: int
    episode: int
    cycle: int
    episode_cycle: int
    ended: str

    def bring_back(self, world: World) -> None:
        """Set the world's counts, and clear the actions that were refused since."""
        for name, value in asdict(self).items():
            setattr(world, name, value)
        world.refused = {}


SNAPSHOT_COUNTS = ("seed", "episode", "cycle", "episode_cycle")


def header(world: ParameterizedWorld, version: int) -> dict[str, Any]:
    """Return the first fields of a snapshot.

    Args:
        world: the world.
        version: version of the layout of this kind of world's snapshots.
    """
    moment = {name: getattr(world, name) for name in (*SNAPSHOT_COUNTS, "ended")}
    return {**_origin(world, version), **moment}


@contextmanager
def reading(
    snapshot: Mapping[str, Any], world: ParameterizedWorld, version: int
) -> Iterator[SnapshotHeader]:
    """Check a snapshot's header, and refuse the snapshot if reading the rest of it fails.

    Args:
        snapshot: the snapshot to restore.
        world: the world to restore it in. Until all of it was read, the world must not change.
        version: as in `header`.

    Raises:
        WorldError: if the snapshot is damaged, or of a world of another kind or other parameters.
    """
    try:
        for key, mine in _origin(world, version).items():
            if snapshot.get(key) != mine:
                way_out = (
                    "another version of HiTAB took it: take a new snapshot"
                    if key == "version"
                    else "restore it in a world like the one it was taken from"
                )
                raise WorldError(f"{_difference(key, snapshot.get(key), mine)}; {way_out}")
        counts = {name: whole(snapshot[name]) for name in SNAPSHOT_COUNTS}
        yield SnapshotHeader(**counts, ended=text(snapshot["ended"]))
    except WorldError:
        raise
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise WorldError(
            f"the snapshot is damaged: {type(error).__name__} {error}; take another one"
        ) from None


def whole(value: Any) -> int:
    """Return a value that must be a whole number.

    Raises:
        TypeError: if it is not.
    """
    if type(value) is not int:
        raise TypeError(f"{value!r} is not a whole number")
    return value


def text(value: Any) -> str:
    """Return a value that must be text.

    Raises:
        TypeError: if it is not.
    """
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is not text")
    return value


def texts(values: Any) -> list[str]:
    """Return values that must be a list of texts.

    Raises:
        TypeError: if they are not.
    """
    if not isinstance(values, list):
        raise TypeError(f"{values!r} is not a list")
    return [text(value) for value in values]


def finite(value: Any) -> float:
    """Return a value that must be a finite number.

    Raises:
        TypeError: if it is not.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise TypeError(f"{value!r} is not a finite number")
    return value


def _difference(key: str, there: Any, here: Any) -> str:
    """Return the differences between a snapshot and the world where it should be restored."""
    if not isinstance(there, Mapping) or not isinstance(here, Mapping):
        return f"the snapshot's {key} is {there}, this world's is {here}"
    names = sorted(name for name in {*there, *here} if there.get(name) != here.get(name))
    differences = [f"{name}: {there.get(name)} there, {here.get(name)} here" for name in names]
    return f"the snapshot was taken with other {key} ({some(differences)})"


def _origin(world: ParameterizedWorld, version: int) -> dict[str, Any]:
    """Return the fields that must match in the world where a snapshot is restored."""
    parameters = world.parameters.as_dict()
    return {"world": world.name, "version": version, "parameters": parameters}
