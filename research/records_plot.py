"""Draws which part of the episodes lasts how long, from the figures of `records.py`.

    scripts/python research/records.py --episodes 200 --seed 9001 --json here.json
    scripts/python research/records_on_rcssserver.py --player keepaway_player --json noisy.json
    scripts/python research/records_plot.py here.json --noisy noisy.json --plot records.png

A mean hides how much episodes differ: the longest last thirty times as long as the shortest.
"""

from __future__ import annotations

import json as js
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hitab_cli.views.plots import figure, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIGHTS = {"quantised": "noisy", "full": "full"}
MEANS: dict[str, dict[str, float]] = {
    "quantised": {"UT hand, real server": 18.3},
    "full": {"UT hand, real server": 32.9, "reinforcement learning, jointly": 88.0},
}
"""Mean hold times of others, s; research/beyond-the-paper.md names their sources."""


def lasting(seconds: Sequence[float]) -> tuple[list[float], list[float]]:
    """Return times, s, in ascending order, and the fraction of episodes that last longer."""
    times = sorted(seconds)
    return times, [1.0 - (n + 1) / len(times) for n in range(len(times))]


def draw_one(axes: Axes, title: str, seconds: Sequence[float], color: str, style: str) -> None:
    """Draw the curve of some episodes."""
    times, fractions = lasting(seconds)
    mean = sum(seconds) / len(seconds)
    axes.step(
        [0.0, *times],
        [1.0, *fractions],
        where="post",
        color=color,
        linestyle=style,
        linewidth=1.3,
        label=f"{title}: mean {mean:.0f} s of {len(seconds)}",
    )


def draw(here: dict[str, Any], server: dict[str, Sequence[float]], path: Path) -> None:
    """Draw the curves, one pair of axes for each kind of sight."""
    drawing, axes = figure(10.0, 4.2)
    grid = drawing.add_gridspec(1, 2)
    axes.remove()
    for column, (sight, protocol) in enumerate(SIGHTS.items()):
        axes = drawing.add_subplot(grid[0, column])
        for title, result in here.get(sight, {}).items():
            trained = title.startswith("trained")
            color, style = ("#1f5fb4", "-") if trained else ("#c44e52", ":")
            draw_one(axes, f"{title}, this world", result["seconds"], color, style)
        if sight in server:
            draw_one(axes, "trained, real server", server[sight], "#2f8f4e", "-")
        for dashes, (who, mean) in zip(("--", "-."), MEANS[sight].items(), strict=False):
            axes.axvline(
                mean,
                color="black",
                linestyle=dashes,
                linewidth=1.0,
                label=f"{who}: mean {mean:g} s",
            )
        axes.set_xscale("log")
        axes.set_xlim(2.0, 3000.0)
        axes.set_ylim(0.0, 1.0)
        axes.set_xlabel("hold time, s (log scale)")
        axes.set_ylabel("fraction of episodes that last longer")
        axes.set_title(f"{protocol}, takers at full speed", fontsize=10)
        axes.grid(alpha=0.3, which="both", linewidth=0.4)
        axes.legend(fontsize=7, loc="lower left")
    save(drawing, path)


def main(
    here: Annotated[Path, typer.Argument(help="JSON file of records.py.")],
    plot: Annotated[Path, typer.Option(help="File for the plot, PNG or SVG.")],
    noisy: Annotated[
        Path | None, typer.Option(help="JSON file of records_on_rcssserver.py.")
    ] = None,
    full: Annotated[
        Path | None, typer.Option(help="The same, of a run with --sight full.")
    ] = None,
) -> None:
    """Draw which part of the episodes lasts how long."""
    server = {
        sight: read(path)["each_seconds"]
        for sight, path in zip(SIGHTS, (noisy, full), strict=True)
        if path is not None
    }
    draw(read(here), server, plot)


def read(path: Path) -> dict[str, Any]:
    """Return the figures of a file.

    Raises:
        BadParameter: if there is none.
    """
    try:
        figures: dict[str, Any] = js.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise typer.BadParameter(f"{path} cannot be read: {error}") from None
    return figures


if __name__ == "__main__":
    typer.run(main)
