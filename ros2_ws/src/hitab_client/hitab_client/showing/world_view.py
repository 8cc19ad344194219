"""One moment of a world: its true state and the agents' reports."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from hitab_client.errors import LessonError
from hitab_core import has

CLOSEST = "closest "


class Thing(Protocol):
    """An entity of a world: an `Entity` message, or anything with the same fields."""

    name: str
    kind: str
    x: float
    y: float
    heading: float
    vx: float
    vy: float
    say: str


def no_reading(agent: str, feature: str) -> float:
    """Raise an error, since no service reads the agents' features."""
    raise LessonError(f"the feature values of {agent} are unavailable here")


@dataclass(frozen=True)
class WorldView:
    """A world at one moment.

    Attributes:
        things: true state of everything in the world; None without a world.
        seconds: simulated seconds since the step of the lesson began.
        paths: active states of each agent, by name.
        said: names of the agents that have spoken since the step began.
        ended: outcomes of the episodes that have ended since the step began.
        reading: returns a feature's value, given an agent's name and the feature; NaN without a
            value.
    """

    things: Sequence[Thing] | None
    seconds: float = 0.0
    paths: Mapping[str, Sequence[str]] | None = None
    said: frozenset[str] = frozenset()
    ended: tuple[str, ...] = ()
    reading: Callable[[str, str], float] = no_reading

    def thing(self, name: str, seen_from: str = "") -> Thing:
        """Return a thing by name, or ``closest KIND`` as seen from another thing.

        Raises:
            LessonError: if there is no such thing.
        """
        if self.things is None:
            raise LessonError(
                f'the place of "{name}" is unknown, since there is no world; ask for a '
                'feature of an agent, such as {feature: "DistanceTo(ball)", below: 2}'
            )
        if name.startswith(CLOSEST):
            kind = name[len(CLOSEST) :]
            near = [t for t in self.things if t.kind == kind and t.name != seen_from]
            if not near or not seen_from:
                kinds = has({t.kind for t in self.things}, kind)
                raise LessonError(f'there is no "{kind}" here {kinds}')
            origin = self.thing(seen_from)
            return min(near, key=lambda t: math.hypot(t.x - origin.x, t.y - origin.y))
        for thing in self.things:
            if thing.name == name:
                return thing
        names = [t.name for t in self.things]
        raise LessonError(f'there is no "{name}" in the world {has(names, name)}')

    def distance(self, one: str, other: str) -> float:
        """Return the distance between two things, m."""
        a, b = self.thing(one), self.thing(other, one)
        return math.hypot(b.x - a.x, b.y - a.y)

    def bearing(self, one: str, other: str) -> float:
        """Return the angle between a thing's heading and another thing, 0 to 180 degrees."""
        a, b = self.thing(one), self.thing(other, one)
        off = math.atan2(b.y - a.y, b.x - a.x) - a.heading
        return abs(math.degrees(math.atan2(math.sin(off), math.cos(off))))

    def speed(self, name: str) -> float:
        """Return the speed of a thing, m/s."""
        thing = self.thing(name)
        return math.hypot(thing.vx, thing.vy)


def speakers(things: Iterable[Thing]) -> frozenset[str]:
    """Return the names of the things that are speaking."""
    return frozenset(thing.name for thing in things if thing.say)
