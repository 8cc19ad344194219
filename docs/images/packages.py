"""Draws docs/images/packages.svg: the packages on their floors, and which imports which.

    scripts/python docs/images/packages.py

Imports that follow from others are left out.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl

mpl.use("svg")
import matplotlib.pyplot as plt

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "tests"))

from test_architecture import FLOORS, PACKAGES, imports, modules  # noqa: E402

WORDS = {
    "hitab_core": "engine, no ROS: learning,\nrunning, training, library",
    "hitab_ros": "guarded nodes, names, QoS",
    "hitab_agent": "node of an agent,\nhost of many",
    "hitab_client": "what programs talk\nto a swarm with; lessons",
    "hitab_world": "node of any\nsimulated world",
    "hitab_commander": "virtual commanders",
    "hitab_robots": "robots with standard\nmessages; relay",
    "hitab_studio": "browser console",
    "hitab_bringup": "swarm files, supervision,\nevaluation, doctor",
    "hitab_cli": "the hitab command",
    "hitab_machines": "swarms on several\nmachines: leases, moves",
    "foraging_world": "box foraging: world, swarms,\nlessons, libraries",
    "keepaway_world": "soccer: world, swarms,\nlessons, libraries",
    "hitab_class": "exercises and grading",
    "hitab_export": "behaviors as programs",
    "hitab_gamepad": "training and driving\nwith a gamepad",
    "half_field_world": "half-field attack, in roles",
    "hitab_rcssserver": "soccer on a real\nRoboCup server",
}
COLUMN = {
    "hitab_core": 0.0,
    "hitab_ros": 0.0,
    "hitab_agent": -3.1,
    "hitab_client": 0.0,
    "hitab_world": 3.6,
    "hitab_commander": -3.1,
    "hitab_robots": -6.0,
    "hitab_studio": 0.9,
    "hitab_bringup": -1.5,
    "hitab_cli": -1.5,
    "hitab_machines": -1.5,
    "foraging_world": 7.0,
    "keepaway_world": 4.0,
    "hitab_class": -5.4,
    "hitab_export": -3.0,
    "hitab_gamepad": 0.0,
    "half_field_world": 4.0,
    "hitab_rcssserver": 4.0,
}
WIDTH, HEIGHT, GAP = 2.6, 0.8, 0.5


def needs() -> dict[str, set[str]]:
    """Return what each package imports, without what that imports itself."""
    used = {
        package: {m.partition(".")[0] for p in modules(package).values() for m, _ in imports(p)}
        & set(PACKAGES) - {package}
        for package in PACKAGES
    }
    every: dict[str, set[str]] = {}
    for package in PACKAGES:  # from the lowest floor up
        every[package] = used[package].union(*(every[below] for below in used[package]))
    return {
        package: found - set().union(*(every[below] for below in found))
        for package, found in used.items()
    }


def main() -> None:
    """Draw it."""
    mpl.rcParams.update({"svg.hashsalt": "hitab", "svg.fonttype": "none", "font.size": 8})
    figure, axes = plt.subplots(figsize=(12.5, 7.4))
    place = {}
    for height, floor in enumerate(FLOORS):
        for package in floor:
            place[package] = (COLUMN[package], height * (HEIGHT + GAP))
    for package, found in needs().items():
        for below in sorted(found):
            (x, y), (u, v) = place[package], place[below]
            arrow = {"arrowstyle": "-|>", "color": "#8a93a3", "shrinkA": 0, "shrinkB": 0}
            axes.annotate("", (u, v + HEIGHT / 2), (x, y - HEIGHT / 2), arrowprops=arrow, zorder=1)
    for package, (x, y) in place.items():
        corner = (x - WIDTH / 2, y - HEIGHT / 2)
        box = plt.Rectangle(corner, WIDTH, HEIGHT, fc="#eef3fb", ec="#33507d", zorder=2)
        axes.add_patch(box)
        axes.text(x, y + 0.25, package, ha="center", va="center", weight="bold", zorder=3)
        axes.text(x, y - 0.1, WORDS[package], ha="center", va="center", fontsize=7, zorder=3)
    axes.set_xlim(-7.5, 8.5)
    axes.set_ylim(-0.7, (len(FLOORS) - 1) * (HEIGHT + GAP) + 0.7)
    axes.axis("off")
    figure.savefig(HERE / "packages.svg", metadata={"Date": None}, bbox_inches="tight")


if __name__ == "__main__":
    main()
