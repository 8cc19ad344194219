"""Damaged copies of a snapshot, to check that a world refuses them."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from random import Random
from typing import Any

LIKE_EACH_OTHER = 3
"""How many values of a list are tried; a random generator has hundreds."""

Path = tuple[Any, ...]
"""Keys and indices that lead to a value in nested dictionaries and lists."""


def damaged_copies(snapshot: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield damaged copies, each after a text that names the damage, such as ``without "seed"``.

    Args:
        snapshot: JSON-able; it is not changed.
    """
    for key in snapshot:
        yield f'without "{key}"', {k: value for k, value in snapshot.items() if k != key}
    alike: dict[Path, list[Path]] = {}
    for path in _leaves(snapshot):
        alike.setdefault(tuple(key for key in path if isinstance(key, str)), []).append(path)
    random = Random(0)
    for paths in alike.values():
        for path in random.sample(paths, min(len(paths), LIKE_EACH_OTHER)):
            damaged = part = copy.deepcopy(snapshot)
            for key in path[:-1]:
                part = part[key]
            wrong = 0.5 if isinstance(part[path[-1]], str) else "damaged"
            part[path[-1]] = wrong
            yield f"with {wrong!r} at {'/'.join(map(str, path))}", damaged


def _leaves(part: Any, path: Path = ()) -> Iterator[Path]:
    """Yield the paths to all values that are neither a dictionary nor a list."""
    if isinstance(part, dict | list):
        for key, value in part.items() if isinstance(part, dict) else enumerate(part):
            yield from _leaves(value, (*path, key))
    else:
        yield path
