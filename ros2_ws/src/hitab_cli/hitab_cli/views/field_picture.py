"""Pictures of the field of a world: positions, headings and paths."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hitab_cli.views.plots import figure, save
from hitab_client import Thing

if TYPE_CHECKING:
    from hitab_msgs.msg import WorldState
    from matplotlib.axes import Axes

COLOR = "#1f5fb4"
"""Color of agents, and of things without a declared color."""
BALL_SHAPE = "ball"
"""Shape of the things that viewers follow with their eyes; see `hitab_world.Look`."""
GROUND = "#5d9150"


def draw_field(states: Sequence[WorldState], path: Path, title: str = "") -> None:
    """Draw the last state of a world, with the paths that led there.

    Args:
        states: states of the world, one per moment.
        path: path of the picture; the suffix selects the format.
        title: title of the picture.
    """
    last, moments = states[-1], [state.entities for state in states]
    width, height = last.width, last.height
    drawing, axes = figure(6.4, 6.4 * height / width + 0.3)
    looks = {look.kind: look for look in last.looks}
    paths = {thing.name: moments for thing in last.entities}
    draw_moment(axes, last.entities, width, height, looks, paths)
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
    looks: Mapping[str, Any],
    paths: Mapping[str, Sequence[Sequence[Thing]]],
) -> None:
    """Draw the field at one moment.

    Args:
        axes: axes to draw on.
        moment: everything in the world.
        width, height: size of the field, m, which is centered on the origin.
        looks: `Look` messages, by kind of thing.
        paths: moments whose path is drawn, by the name of the thing.
    """
    margin = 0.08 * width
    left, low = -width / 2 - margin, -height / 2 - margin
    axes.add_patch(_rectangle(left, low, facecolor=GROUND))
    axes.add_patch(
        _rectangle(-width / 2, -height / 2, fill=False, edgecolor="white", linewidth=1.5)
    )
    for name, moments in paths.items():
        _draw_path(axes, name, moments, looks)
    for thing in sorted(moment, key=lambda thing: _layer(thing, looks)):
        _draw_thing(axes, thing, looks.get(thing.kind))
    axes.set_xlim(left, -left)
    axes.set_ylim(low, -low)
    axes.set_aspect("equal")


def _rectangle(left: float, low: float, **style: Any) -> Any:
    """Return a rectangle that is centered on the origin."""
    from matplotlib.patches import Rectangle

    return Rectangle((left, low), -2.0 * left, -2.0 * low, **style)


def _layer(thing: Thing, looks: Mapping[str, Any]) -> int:
    look = looks.get(thing.kind)
    return 0 if look is None else int(look.layer)


def shape_of(thing: Thing, looks: Mapping[str, Any]) -> str:
    """Return the shape that a world declares for a thing; empty if none."""
    return str(getattr(looks.get(thing.kind), "shape", ""))


def _color(look: Any) -> str:
    return str(getattr(look, "color", "") or COLOR)


def _draw_path(
    axes: Axes, name: str, moments: Sequence[Sequence[Thing]], looks: Mapping[str, Any]
) -> None:
    things = [thing for moment in moments for thing in moment if thing.name == name]
    xs, ys = [thing.x for thing in things], [thing.y for thing in things]
    color = _color(looks.get(things[0].kind))
    axes.plot(xs, ys, color=color, linewidth=1.2, alpha=0.6)


def _draw_thing(axes: Axes, thing: Any, look: Any) -> None:
    from matplotlib.patches import Circle

    # Drawn larger than life, to be visible.
    radius = max(2.0 * thing.radius, 0.22)
    axes.add_patch(
        Circle((thing.x, thing.y), radius, facecolor=_color(look), edgecolor="black", zorder=3)
    )
    if look is None or look.faces:
        axes.plot(
            [thing.x, thing.x + 1.6 * radius * math.cos(thing.heading)],
            [thing.y, thing.y + 1.6 * radius * math.sin(thing.heading)],
            color="black",
            linewidth=1.5,
            zorder=4,
        )
    if look is None or look.labelled:
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
