"""Draws the field of a world: positions, headings and paths."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hitab_bringup.plots import figure, save
from hitab_client import Thing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLORS = {"keeper": "#1f5fb4", "taker": "#c43c2b", "ball": "#f5f5f0"}
GRASS = "#5d9150"


def draw_field(
    moments: Sequence[Sequence[Thing]],
    width: float,
    height: float,
    path: Path,
    title: str = "",
) -> None:
    """Draw the last moment, with the paths that led there.

    Args:
        moments: everything in the world, one entry per moment.
        width, height: of the field, m, which is centered on the origin.
        path: of the picture; the suffix selects the format.
        title: of the picture.
    """
    drawing, axes = figure(6.4, 6.4 * height / width + 0.3)
    draw_moment(axes, moments[-1], width, height, {t.name: moments for t in moments[-1]})
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    if title:
        axes.set_title(title, fontsize=10)
    save(drawing, path)


def draw_moment(
    axes: Axes,
    moment: Sequence[Thing],
    width: float,
    height: float,
    paths: Mapping[str, Sequence[Sequence[Thing]]],
) -> None:
    """Draw the field at one moment.

    Args:
        axes: to draw on.
        moment: everything in the world.
        width, height: of the field, m, which is centered on the origin.
        paths: by the name of a thing, the moments whose path is drawn.
    """
    margin = 0.08 * width
    left, low = -width / 2 - margin, -height / 2 - margin
    axes.add_patch(_rectangle(left, low, facecolor=GRASS))
    axes.add_patch(
        _rectangle(-width / 2, -height / 2, fill=False, edgecolor="white", linewidth=1.5)
    )
    for name, moments in paths.items():
        _draw_path(axes, name, moments)
    for thing in sorted(moment, key=lambda thing: thing.kind == "ball"):
        _draw_thing(axes, thing)
    axes.set_xlim(left, -left)
    axes.set_ylim(low, -low)
    axes.set_aspect("equal")


def _rectangle(left: float, low: float, **style: Any) -> Any:
    """Return one that is centered on the origin."""
    from matplotlib.patches import Rectangle

    return Rectangle((left, low), -2.0 * left, -2.0 * low, **style)


def _draw_path(axes: Axes, name: str, moments: Sequence[Sequence[Thing]]) -> None:
    things = [thing for moment in moments for thing in moment if thing.name == name]
    xs, ys = [thing.x for thing in things], [thing.y for thing in things]
    axes.plot(xs, ys, color=_color(things[0]), linewidth=1.2, alpha=0.6)


def _color(thing: Thing) -> str:
    return COLORS.get(thing.kind, "#333333")


def _draw_thing(axes: Axes, thing: Any) -> None:
    from matplotlib.patches import Circle

    # Drawn larger than life, to be visible.
    radius = max(2.0 * thing.radius, 0.22)
    axes.add_patch(
        Circle((thing.x, thing.y), radius, facecolor=_color(thing), edgecolor="black", zorder=3)
    )
    if thing.kind == "ball":
        return
    axes.plot(
        [thing.x, thing.x + 1.6 * radius * math.cos(thing.heading)],
        [thing.y, thing.y + 1.6 * radius * math.sin(thing.heading)],
        color="black",
        linewidth=1.5,
        zorder=4,
    )
    number = thing.name.rsplit("_", 1)[-1]
    axes.text(
        thing.x, thing.y, number, color="white", fontsize=8, ha="center", va="center", zorder=5
    )
    if thing.say:
        axes.annotate(
            f"“{thing.say}”",
            (thing.x, thing.y),
            textcoords="offset points",
            xytext=(8, 10),
            fontsize=8,
            color="white",
            zorder=6,
        )
