"""Sizes of keepaway games, as options name them."""

from __future__ import annotations

import re

import typer


def size_of(game: str) -> tuple[int, int]:
    """Return the numbers of keepers and takers of a game such as "4v3".

    Raises:
        BadParameter: if there is no such game.
    """
    found = re.fullmatch(r"([2-9])v([1-9])", game)
    if found is None:
        raise typer.BadParameter(
            f'"{game}" is no game; give 2 to 9 keepers and 1 to 9 takers, as in 4v3',
            param_hint="--game",
        )
    return int(found[1]), int(found[2])
