"""The demo of keepaway, with the paper's figures for comparison."""

from __future__ import annotations

from types import MappingProxyType

from hitab_world.demo import Demo

DEMO = Demo(
    swarm="keepaway",
    lessons=("approach_ball", "goto_ball", "control_ball", "keepaway"),
    behavior="Keepaway",
    against="takers at a quarter of their speed",
    reference="paper",
    references=MappingProxyType({"seconds": (14.6, 0.87), "passes": (3.8, None)}),
    examples=MappingProxyType(
        {"ApproachBall": 18, "GotoBall": 10, "ControlBall": 11, "Keepaway": 10}
    ),
    closing="the paper's demonstrators took 155 minutes",
)
"""Sections 5 and 6 of the paper."""
