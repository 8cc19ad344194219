"""Robots with a link of their own for tests: what each does is in a file of its name.

The folder of the files is in the environment, as FIELD.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from bodies import Body
from hitab_msgs import msg

from hitab_core import BasicBehavior, Domain, Feature


class Driver(Body):
    """A body that drives as its behavior says."""

    speed = 0.0

    def act(self) -> tuple[tuple[float, ...], str]:
        return (self.speed,), ""


def drives(speed: float) -> Any:
    """Return what a behavior does that drives."""
    return lambda body: setattr(body, "speed", speed)


class Link:
    """A link that perceives ten times a second and notes each new speed."""

    def __init__(self, node: Any, world: str, on_percept: Any) -> None:
        self._file = Path(os.environ["FIELD"], node.agent_name)
        self._on_percept = on_percept
        self._speed: float | None = None
        self._cycle = 0
        node.create_timer(0.1, self._perceive)

    def _perceive(self) -> None:
        self._cycle += 1
        percept = msg.Percept(cycle=self._cycle, sequence=self._cycle, values=[1.0])
        action, _ = self._on_percept(percept)
        speed = action[0] if action else 0.0
        if speed != self._speed:
            self._speed = speed
            with self._file.open("a") as file:
                file.write(f"{speed:g}\n")

    def close(self) -> None:
        """Do nothing."""


DOMAIN = Domain.of(
    "field",
    "1",
    Driver,
    behaviors=[
        BasicBehavior("Go", drives(1.0)),
        BasicBehavior("Turn", drives(2.0)),
        BasicBehavior("Stop", drives(0.0), stands_still=True),
    ],
    features=[Feature("X", lambda body: body.x)],
    link="field_robots:Link",
)
