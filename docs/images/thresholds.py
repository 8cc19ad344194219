"""Draws where a behavior changes state, and the examples that taught it: on a line, on a circle.

    scripts/python docs/images/thresholds.py

The automaton in thresholds.svg is the shipped one; circle.svg shows trees of a few examples.
"""

from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from hitab_core import FeatureKind
from hitab_core.automaton import Automaton
from hitab_core.domain import Scale, load_domain
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.library.behavior_library import BehaviorLibrary

HERE = Path(__file__).resolve().parent
LIBRARY = HERE.parents[1] / "ros2_ws/src/keepaway_world/libraries/keepaway"
STATES = ("Start", "GoFast", "GoMedium")
COLORS = {"GoFast": "#2b6cb0", "GoMedium": "#b7791f", "GoSlow": "#2f855a"}
FARTHEST = 13.0  # m
CIRCLES = (
    ("default examples at 0° only", {20: "TurnLeft"}, (0,)),
    ("default examples at 0° and 60°", {20: "TurnLeft"}, (0, 60)),
)
"""What was commanded in Stop with the ball in some directions, degrees, and default examples."""
TURNS = {"Stop": "#718096", "TurnLeft": "#2b6cb0"}


def draw(axes: Any, automaton: Automaton, state: str) -> None:
    """Draw what the transition function of a state decides at each distance."""
    distances = np.linspace(0.0, FARTHEST, 2601)
    decided = automaton.transitions[state].predict(distances[:, None])
    changes = np.flatnonzero(decided[1:] != decided[:-1])
    borders = [0.0, *(distances[changes] + distances[changes + 1]) / 2, FARTHEST]
    for i, behavior in enumerate(decided[[0, *(changes + 1)]]):
        axes.axvspan(borders[i], borders[i + 1], color=COLORS[behavior], alpha=0.16, lw=0)
    for x in borders[1:-1]:
        axes.axvline(x, color="#1f2933", lw=1)
    for example in automaton.examples:
        if example.state == state:
            color = COLORS[example.next_state]
            face = "white" if example.is_default else color
            axes.plot(example.features[0], 0, "o", ms=9, mec=color, mfc=face, mew=2)
    axes.set(xlim=(0, FARTHEST), ylim=(-1, 1), yticks=[])
    axes.set_ylabel(f"in {state}", rotation=0, ha="right", va="center")
    axes.spines[["left", "top", "right"]].set_visible(False)


def draw_circle(
    axes: Any, title: str, commands: dict[int, str], defaults: tuple[int, ...]
) -> None:
    """Draw what is decided in each direction: ahead is at the top, left at the left."""
    given = [*commands.items(), *((degrees, "Stop") for degrees in defaults)]
    scale = Scale(FeatureKind.TOROIDAL, 360.0)
    tree = TransitionTree([scale]).fit(
        [[degrees] for degrees, _ in given],
        [state for _, state in given],
        [state == "Stop" for _, state in given],
    )
    directions = np.arange(0.0, 360.5, 0.5)
    decided = tree.predict(directions[:, None] % 360.0)
    changes = [0, *np.flatnonzero(decided[1:] != decided[:-1]) + 1, len(directions) - 1]
    for first, last in pairwise(changes):
        color, begin, end = TURNS[decided[first]], directions[first], directions[last]
        wedge = np.deg2rad([(begin + end) / 2, end - begin])
        axes.bar(wedge[0], 1.0, width=wedge[1], color=color, alpha=0.25, lw=0)
    for degrees, state in given:
        face = "white" if state == "Stop" else TURNS[state]
        axes.plot(
            np.deg2rad(degrees), 1.0, "o", ms=8, mec=TURNS[state], mfc=face, mew=2, clip_on=False
        )
    labels = sorted(
        {0, 90, 180, 270, *(degrees for degrees, _ in given), *np.rint(directions[changes[1:-1]])}
    )
    axes.set_thetagrids(labels, [f"{d if d <= 180 else d - 360:.0f}°" for d in labels])
    axes.set(theta_zero_location="N", ylim=(0, 1), yticks=[])
    axes.set_title(title, fontsize=10, pad=14)


def draw_circles() -> None:
    """Draw circle.svg."""
    figure = Figure(figsize=(6.4, 3.3))
    parts = figure.subplots(1, len(CIRCLES), subplot_kw={"projection": "polar"})
    for axes, circle in zip(parts, CIRCLES, strict=True):
        draw_circle(axes, *circle)
    dots: dict[str, Any] = {"ls": "", "marker": "o", "ms": 8, "mew": 2}
    keys = [Line2D([], [], color=TURNS["TurnLeft"], **dots)]
    keys.append(Line2D([], [], mec=TURNS["Stop"], mfc="white", **dots))
    labels = ["command: TurnLeft", "default example: Stop"]
    figure.legend(keys, labels, loc="lower center", ncol=2, frameon=False)
    figure.subplots_adjust(left=0.08, right=0.92, top=0.78, bottom=0.2, wspace=0.45)
    with mpl.rc_context({"svg.hashsalt": "circle"}):
        figure.savefig(HERE / "circle.svg", metadata={"Date": None})


def main() -> None:
    """Draw the pictures."""
    draw_circles()
    automaton = BehaviorLibrary(LIBRARY, load_domain("keepaway")).load()["ApproachBall"]
    figure = Figure(figsize=(7.5, 3.2))
    rows = figure.subplots(len(STATES), sharex=True)
    for axes, state in zip(rows, STATES, strict=True):
        draw(axes, automaton, state)
    rows[-1].set_xlabel("DistanceTo(ball), m")
    dots: dict[str, Any] = {"ls": "", "marker": "o", "ms": 8, "mew": 2}
    keys = [Line2D([], [], color=color, **dots) for color in COLORS.values()]
    keys.append(Line2D([], [], mec="#1f2933", mfc="white", **dots))
    figure.legend(keys, [*COLORS, "default example"], loc="upper center", ncol=4, frameon=False)
    figure.subplots_adjust(left=0.15, right=0.98, top=0.86, bottom=0.16, hspace=0.25)
    # The same examples give the same file.
    with mpl.rc_context({"svg.hashsalt": "thresholds"}):
        figure.savefig(HERE / "thresholds.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
