"""A room of ir-sim with robots and obstacles, another one for each seed. No ROS, no HiTAB here."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

WIDTH, HEIGHT = 9.0, 7.0  # m
WAYPOINTS = {"A": (1.5, 1.5), "B": (7.5, 1.5), "C": (7.5, 5.5), "D": (1.5, 5.5)}  # m
HULL = 0.2  # m: radius of a robot
BEAMS = 72
RANGE_MIN, RANGE_MAX = 0.05, 6.0  # m

CELLS = [(3.1, 2.2), (6.1, 2.2), (2.9, 4.9), (5.9, 4.9)]
"""Around these points, m, are the obstacles, so that there is a way between any two."""
STRAY = 0.25  # m: how far an obstacle may be from its point, in x and in y
CLEARANCE = 0.8  # m: free space around a robot when it starts
TRIES = 10_000


def _obstacles(rng: np.random.Generator) -> list[dict[str, Any]]:
    found = []
    for x, y in CELLS:
        side = rng.uniform(0.3, 0.7, 2)
        place = [*(np.array([x, y]) + rng.uniform(-STRAY, STRAY, 2)), rng.uniform(0.0, math.pi)]
        found.append(
            {
                "shape": {"name": "rectangle", "length": float(side[0]), "width": float(side[1])},
                "state": [float(number) for number in place],
            }
        )
    return found


def _starts(rng: np.random.Generator, count: int, taken: list[Any]) -> list[list[float]]:
    """Return poses in the room, away from walls, obstacles and each other."""
    found: list[list[float]] = []
    for _ in range(TRIES):
        if len(found) == count:
            return found
        x = rng.uniform(CLEARANCE, WIDTH - CLEARANCE)
        y = rng.uniform(CLEARANCE, HEIGHT - CLEARANCE)
        around = [(o["state"], CLEARANCE + 0.5) for o in taken] + [(s, 1.5) for s in found]
        if all(math.dist((x, y), other[:2]) > distance for other, distance in around):
            found.append([float(x), float(y), float(rng.uniform(-math.pi, math.pi))])
    raise ValueError(f"no room for {count} robots")


def room(seed: int, robots: int, step: float, yaw: float = 0.0) -> dict[str, Any]:
    """Return ir-sim's description of a room.

    Args:
        seed: of the obstacles and of where the robots start.
        robots: how many.
        step: s, between two states of the simulation.
        yaw: which way the scanners face on the robots, rad, counter-clockwise from ahead.
    """
    rng = np.random.default_rng(seed)
    obstacles = _obstacles(rng)
    starts = _starts(rng, robots, obstacles)
    scanner = {
        "name": "lidar2d",
        "range_min": RANGE_MIN,
        "range_max": RANGE_MAX,
        # From the first beam to the last: the one that would close the circle is left out.
        "angle_range": math.tau * (BEAMS - 1) / BEAMS,
        "number": BEAMS,
        "offset": [0.0, 0.0, yaw],
    }
    robot = {
        "number": 1,
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": HULL},
        "vel_max": [1.0, 3.0],
        "vel_min": [-1.0, -3.0],
        "sensors": [scanner],
    }
    walls = [[0.0, 0.0], [WIDTH, 0.0], [WIDTH, HEIGHT], [0.0, HEIGHT], [0.0, 0.0]]
    return {
        "world": {
            "width": WIDTH,
            "height": HEIGHT,
            "step_time": step,
            "sample_time": step,
            # A robot that hits something stays there: a collision cannot be missed.
            "collision_mode": "stop",
        },
        "robot": [robot | {"state": start} for start in starts],
        "obstacle": [
            *obstacles,
            {"shape": {"name": "linestring", "vertices": walls}, "state": [0.0, 0.0, 0.0]},
        ],
    }
