"""Keeps what a long benchmark has finished, so that it can go on after an interruption."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

Resume = Annotated[
    str,
    typer.Option(
        help="File that keeps each finished run; with the same settings and file, the benchmark "
        "goes on where it was interrupted."
    ),
]


class FinishedRuns:
    """The figures of finished runs, by name, each kept in a file at once.

    The file has one JSON text per line: first the settings, then a name and its figures each. A
    last line that was not written whole is ignored.

    Args:
        path: of the file, which may be missing; empty: nothing is kept.
        settings: that all runs have in common; what JSON makes of them is compared.

    Attributes:
        figures: of each finished run, as JSON gives them back.

    Raises:
        typer.BadParameter: if the file holds runs with other settings, or something else.
    """

    def __init__(self, path: str, settings: Mapping[str, Any]) -> None:
        self.figures: dict[str, Any] = {}
        self._path = Path(path) if path else None
        if self._path is None:
            return
        begun = json.dumps(settings, sort_keys=True) + "\n"
        try:
            kept = self._path.read_text("utf-8") if self._path.exists() else ""
            whole = kept[: kept.rfind("\n") + 1]
            if whole and not whole.startswith(begun):
                raise typer.BadParameter(
                    f"{path} is not of this benchmark with these settings; name another file"
                )
            if not whole:
                self._path.write_text(begun, "utf-8")
            elif whole != kept:
                self._path.write_text(whole, "utf-8")
            self.figures.update(json.loads(line) for line in whole.splitlines()[1:])
        except (OSError, ValueError) as wrong:
            raise typer.BadParameter(f"{path} cannot be used: {wrong}") from None

    def add(self, name: str, figures: Any) -> None:
        """Keep the figures of a run."""
        self.figures[name] = figures
        if self._path is not None:
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps([name, figures]) + "\n")
