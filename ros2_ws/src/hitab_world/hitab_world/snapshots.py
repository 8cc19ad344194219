"""What the snapshots of all worlds have in common: what they are of, and when.

A world's `World.snapshot` returns `header` and, under further keys, its own state; its `restore`
reads that within `reading`, which refuses what is not of such a world or is damaged::

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

from hitab_world.parameters import Parameters
from hitab_world.world import World, WorldError


class WorldOfFigures(World, Protocol):
    """A world that has figures, without which its state means nothing."""

    @property
    def parameters(self) -> Parameters:
        """Its figures."""


@dataclass(frozen=True, slots=True)
class Moment:
    """When a snapshot was taken; the fields are those of `World`."""

    seed: int
    episode: int
    cycle: int
    episode_cycle: int
    ended: str

    @classmethod
    def of(cls, state: Mapping[str, Any]) -> Moment:
        """Return the moment that a snapshot's header tells.

        Raises:
            KeyError, TypeError: if it tells none.
        """
        return cls(
            seed=whole(state["seed"]),
            episode=whole(state["episode"]),
            cycle=whole(state["cycle"]),
            episode_cycle=whole(state["episode_cycle"]),
            ended=text(state["ended"]),
        )

    def bring_back(self, world: World) -> None:
        """Set the world's counts, and forget what was refused since."""
        for name, value in asdict(self).items():
            setattr(world, name, value)
        world.refused = {}


def header(world: WorldOfFigures, version: int) -> dict[str, Any]:
    """Return what a snapshot of a world begins with.

    Args:
        world: of which it is taken.
        version: of the layout of this kind of world's snapshots.
    """
    moment = Moment(world.seed, world.episode, world.cycle, world.episode_cycle, world.ended)
    return {**_origin(world, version), **asdict(moment)}


@contextmanager
def reading(snapshot: Mapping[str, Any], world: WorldOfFigures, version: int) -> Iterator[Moment]:
    """Check a snapshot's header, and refuse the snapshot if reading the rest of it fails.

    Args:
        snapshot: to be restored.
        world: in which; it must not be changed in the body.
        version: as in `header`.

    Raises:
        WorldError: if it is of another kind of world, of one with other figures, or damaged.
    """
    try:
        for key, mine in _origin(world, version).items():
            if snapshot.get(key) != mine:
                raise WorldError(
                    f"the snapshot's {key} is {snapshot.get(key)}, this world's is {mine}; "
                    "restore it in a world like the one that it was taken of"
                )
        yield Moment.of(snapshot)
    except WorldError:
        raise
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise WorldError(
            f"the snapshot is damaged: {type(error).__name__} {error}; take another one"
        ) from None


def whole(value: Any) -> int:
    """Return a value that must be a whole number.

    Raises:
        TypeError: if it is none.
    """
    if not isinstance(value, int) or isinstance(value, bool):
        raise TypeError(f"{value!r} is no whole number")
    return value


def text(value: Any) -> str:
    """Return a value that must be text.

    Raises:
        TypeError: if it is none.
    """
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is no text")
    return value


def texts(values: Any) -> list[str]:
    """Return values that must be a list of texts.

    Raises:
        TypeError: if they are none.
    """
    if not isinstance(values, list):
        raise TypeError(f"{values!r} is no list")
    return [text(value) for value in values]


def finite(value: Any) -> float:
    """Return a value that must be a finite number.

    Raises:
        TypeError: if it is no number.
        ValueError: if it is not finite.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{value!r} is no number")
    if not math.isfinite(value):
        raise ValueError(f"{value} is not finite")
    return value


def _origin(world: WorldOfFigures, version: int) -> dict[str, Any]:
    """Return what must be the same in the world where a snapshot is restored."""
    return {
        "world": world.name,
        "version": version,
        "parameters": world.parameters.as_dict(),
    }
