"""The situations in which simulated people train: how they arrange the field.

A person arranges the field while the world is paused, more or less as meant, and then lets it run.
Players who are not needed stand aside.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random

from intentions import BALL, KICKABLE, OFF, Seen

from hitab_world import Placement

Placements = tuple[Placement, ...]


def _never(state: str, seen: Seen) -> bool:
    return False


@dataclass(frozen=True)
class Scene:
    """A situation to train in.

    Attributes:
        start: where everything is at first; players that are not named are drawn by the referee.
        seconds: the longest that the person lets it run, s.
        over: whether the situation has been played to its end, given state and percept.
        broken: whether it cannot be played to its end any more.
        twist: a change made while the scene is played; empty: none.
        turn: when the twist is due.
        lasts: how long it goes on if all do what they should, s.
    """

    start: Placements
    seconds: float
    over: Callable[[str, Seen], bool] = _never
    broken: Callable[[str, Seen], bool] = _never
    twist: Placements = ()
    turn: Callable[[str, Seen], bool] = _never
    lasts: float = 0.0

    @property
    def ends(self) -> bool:
        """Whether there is an end to which it should be played."""
        return self.over is not _never


def _at(
    name: str, x: float, y: float, heading: float = 0.0, vx: float = 0.0, vy: float = 0.0
) -> Placement:
    return Placement(name, x, y, heading, vx, vy)


_ASIDE = (
    _at("keeper_2", 9.0, 9.0),
    _at("keeper_3", 9.0, -9.0),
    _at("taker_1", -9.0, 9.0),
    _at("taker_2", -9.0, 8.0),
)


def approaching(random: Random, turn: int) -> Scene:
    """Put the ball straight ahead, lying or rolling, first far away, then at any distance."""
    far = turn % 3 == 0
    away = random.uniform(9.0, 13.0) if far else random.uniform(1.5, 7.0)
    speed = random.uniform(4.0, 10.0) if turn % 3 == 1 else 0.0
    y = random.uniform(-3.0, 3.0)
    x = -9.0 if far else -6.0
    on = random.choice((1.6, 3.0, 6.0))

    def passed(state: str, seen: Seen) -> bool:
        return abs(seen[OFF]) > math.radians(60.0) and seen[BALL] > 0.6

    def stopped(state: str, seen: Seen) -> bool:
        return state == "Stop" and seen[BALL] < 1.2

    return Scene(
        (*_ASIDE, _at("keeper_1", x, y), _at("ball", x + away, y, 0.0, speed, 0.0)),
        6.0,
        stopped,
        passed,
        # The keeper comes to rest where it is; the ball is put farther on.
        (_at("keeper_1", -6.0, y), _at("ball", -6.0 + on, y)) if turn % 2 == 0 else (),
        stopped,
    )


def going(random: Random, turn: int) -> Scene:
    """Put the ball somewhere around the keeper, lying or rolling."""
    side = 1.0 if turn % 2 else -1.0
    bearing = 0.0 if turn % 3 == 2 else random.uniform(0.5, math.pi) * side
    away = random.uniform(4.0, 8.0)
    x, y = random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0)
    across = bearing + math.pi / 2.0
    speed = random.uniform(2.0, 5.0) * (side if turn % 4 < 2 else -side)

    def there(state: str, seen: Seen) -> bool:
        return seen[BALL] < 1.0

    return Scene(
        (
            *_ASIDE,
            _at("keeper_1", x, y),
            _at(
                "ball",
                x + away * math.cos(bearing),
                y + away * math.sin(bearing),
                0.0,
                speed * math.cos(across),
                speed * math.sin(across),
            ),
        ),
        5.0,
        there,
    )


def controlling(random: Random, turn: int) -> Scene:
    """Put the ball near and let takers come; every other time take the ball away again."""
    x = random.uniform(-5.0, -2.0)
    away = 0.7 if turn % 3 == 2 else random.uniform(2.0, 4.0)
    taker = random.uniform(5.0, 8.0)
    lost = random.uniform(2.0, 3.5)

    def passed(state: str, seen: Seen) -> bool:
        return not seen[KICKABLE] and seen[BALL] > 5.0

    def waits(state: str, seen: Seen) -> bool:
        return state == "Stop" and bool(seen[KICKABLE])

    return Scene(
        (
            _at("keeper_1", x, 0.0),
            _at("keeper_2", 6.0, 6.0),
            _at("keeper_3", 6.0, -6.0),
            _at("taker_1", x + away + taker, 1.0, math.pi),
            _at("taker_2", x + away + taker, -1.0, math.pi),
            _at("ball", x + away, 0.0),
        ),
        12.0,
        passed,
        _never,
        (
            _at("keeper_1", x + away - 0.6, 0.0),
            _at("ball", x + away + lost, lost * random.uniform(-0.5, 0.5)),
        )
        if turn % 2
        else (),
        waits,
    )


def having_the_ball(random: Random, turn: int) -> Scene:
    """Put the keeper closest to the ball, and the takers far away."""
    return Scene(
        (
            _at("keeper_1", -8.0 + random.uniform(-1, 1), 8.0 + random.uniform(-1, 1)),
            _at("keeper_2", 8.0, 8.0, math.pi),
            _at("keeper_3", 8.0, -8.0, math.pi / 2),
            _at("taker_1", -8.0, -8.0, math.pi / 2),
            _at("taker_2", -7.0, -8.0, math.pi / 2),
            _at("ball", -6.0, 6.0),
        ),
        14.0,
    )


def being_open(random: Random, turn: int) -> Scene:
    """Give the ball to a teammate, with a taker near it."""
    return Scene(
        (
            _at("keeper_1", 8.0 + random.uniform(-1, 1), 8.0 + random.uniform(-1, 1), math.pi),
            _at("keeper_2", -8.0, 8.0),
            _at("keeper_3", -8.0, -8.0, math.pi / 2),
            _at("taker_1", -7.0, -3.0 + random.uniform(-1, 1), math.pi / 2),
            _at("taker_2", -6.0, -3.0, math.pi / 2),
            _at("ball", -6.0, 6.0),
        ),
        14.0,
    )


def playing(random: Random, turn: int) -> Scene:
    """Play a whole game; nobody is content who sees the ball lost soon."""
    return Scene((), 25.0, lasts=12.0)


SCENES: Mapping[str, Callable[[Random, int], Scene]] = {
    "ApproachBall": approaching,
    "GotoBall": going,
    "ControlBall": controlling,
}
