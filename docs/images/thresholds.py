"""Draws thresholds.svg: where a trained behavior changes state, and the examples that taught it.

    scripts/python docs/images/thresholds.py

The automaton is the shipped one.
"""

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from hitab_core.automaton import Automaton
from hitab_core.domain import load_domain
from hitab_core.library.behavior_library import BehaviorLibrary

HERE = Path(__file__).resolve().parent
LIBRARY = HERE.parents[1] / "ros2_ws/src/keepaway_world/libraries/keepaway"
STATES = ("Start", "GoFast", "GoMedium")
COLORS = {"GoFast": "#2b6cb0", "GoMedium": "#b7791f", "GoSlow": "#2f855a"}
FARTHEST = 13.0  # m


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


def main() -> None:
    """Draw the picture."""
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
