"""A keeper's body: the percept and the one command of a cycle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from hitab_core import FeatureValueError, quantity
from keepaway_world import percept
from keepaway_world.action import DASH, KICK, TURN
from keepaway_world.game.angles import PI, wrapped
from keepaway_world.parameters import PAPER, KeepawayParameters
from keepaway_world.percept import BALL, CYCLES_PER_SECOND, OTHER_PLAYERS

NO_PLAYER = -1
"""The place of a missing player, such as the closest taker if there are none."""

CORNERS = {-2: (-1.0, 1.0), -3: (1.0, 1.0), -4: (1.0, -1.0), -5: (-1.0, -1.0)}
"""The places of the box's corners, with the signs of their x and y; percepts do not hold them."""

YELL = "pass {}"
"""A passer's yell with the receiver's number; 10 characters at most, for numbers to 99999."""


class KeeperBody:
    """The `hitab_core.domain.Body` of one keeper.

    The ball and players are identified by their *place* in the percept: the index of their
    distance, followed by their direction. `dash`, `turn_by` and `kick` set the command of this
    cycle; the last call counts, since a keeper gives at most one command per cycle.

    Args:
        name: name of the agent.
        parameters: the mechanics that the keeper assumes; speeds are in m/cycle.

    Attributes:
        values: the percept, in the layout and units of `keepaway_world.percept`.
        heard: the messages heard in this cycle.
    """

    fixed: Mapping[int, tuple[float, float]] = CORNERS
    """Fixed places, which percepts do not hold, as fractions of half the width and the height."""

    def __init__(self, name: str, parameters: KeepawayParameters = PAPER) -> None:
        self.name = name
        self.parameters = parameters
        self.values: Sequence[float] = ()
        self.heard: Sequence[str] = ()
        self._keepers = 0
        self._length = self._first_taker = OTHER_PLAYERS
        self._action: list[float] = []
        self._say = ""

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take this cycle's percept; clear the last one and its command.

        Raises:
            FeatureValueError: if the percept does not have a keeper's layout.
        """
        if len(values) != self._length or values[percept.KEEPERS] != self._keepers:
            self._lay_out(values)
        self.values = values
        self.heard = heard
        self._action = []
        self._say = ""

    def _lay_out(self, values: Sequence[float]) -> None:
        if len(values) >= OTHER_PLAYERS and math.isfinite(
            values[percept.KEEPERS] + values[percept.TAKERS]
        ):
            keepers, takers = int(values[percept.KEEPERS]), int(values[percept.TAKERS])
            expected = percept.percept_length(keepers, takers)
            if len(values) == expected:
                self._keepers, self._length = keepers, expected
                self._first_taker = OTHER_PLAYERS + 2 * (keepers - 1)
                return
        raise FeatureValueError(
            f"{self.name}: a percept of {quantity(len(values), 'value')} is not from keepaway; "
            "link the agent to a keepaway world"
        )

    def act(self) -> tuple[Sequence[float], str]:
        """Return this cycle's command, see `keepaway_world.action`, and the message to say."""
        return self._action, self._say

    # Commands.

    def dash(self, power: float) -> None:
        """Dash along the body with a power from -100 to 100."""
        self._action = [DASH, power]

    def turn_by(self, angle: float) -> None:
        """Turn by ``angle`` rad, or as far as one turn goes; less at higher speed."""
        moment = angle * (1.0 + self.parameters.inertia * self.speed)
        self._action = [TURN, min(max(moment, -PI), PI)]

    def kick(self, power: float, direction: float) -> None:
        """Kick with a power from 0 to 100 towards ``direction``, rad relative to the body."""
        self._action = [KICK, power, direction]

    def say(self, message: str) -> None:
        """Say something that the others hear in the next cycle."""
        self._say = message

    # The percept.

    @property
    def number(self) -> int:
        """The keeper's number, from 1."""
        return int(self.values[percept.NUMBER])

    @property
    def position(self) -> tuple[float, float]:
        """The keeper's position, m."""
        return self.values[percept.X], self.values[percept.Y]

    @property
    def heading(self) -> float:
        """The heading of the keeper's body, rad."""
        return self.values[percept.HEADING]

    @property
    def velocity(self) -> tuple[float, float]:
        """The keeper's velocity, m/cycle."""
        values = self.values
        return values[percept.VX] / CYCLES_PER_SECOND, values[percept.VY] / CYCLES_PER_SECOND

    @property
    def speed(self) -> float:
        """The keeper's speed, m/cycle."""
        values = self.values
        return math.hypot(values[percept.VX], values[percept.VY]) / CYCLES_PER_SECOND

    @property
    def ball_velocity(self) -> tuple[float, float]:
        """The ball's velocity in the world's axes, m/cycle."""
        values = self.values
        return (
            values[percept.BALL_VX] / CYCLES_PER_SECOND,
            values[percept.BALL_VY] / CYCLES_PER_SECOND,
        )

    @property
    def ball_is_kickable(self) -> bool:
        """Whether the ball is within kicking range, as far as the keeper can see."""
        return self.values[BALL] <= self.parameters.kickable

    @property
    def others(self) -> range:
        """The places of the other keepers, by rising number."""
        return range(OTHER_PLAYERS, self._first_taker, 2)

    @property
    def takers(self) -> range:
        """The places of the takers."""
        return range(self._first_taker, self._length, 2)

    def number_at(self, place: int) -> int:
        """Return the number of the other keeper at a place."""
        number = (place - OTHER_PLAYERS) // 2 + 1
        return number if number < self.number else number + 1

    def closest_keeper(self) -> int:
        """Return the place of the closest other keeper; on a tie, the lowest number."""
        return self._closest(self.others)

    def closest_taker(self) -> int:
        """Return the place of the closest taker, or `NO_PLAYER`."""
        return self._closest(self.takers)

    def _closest(self, places: range) -> int:
        return min(places, key=self.values.__getitem__, default=NO_PLAYER)

    def vector_to(self, place: int) -> tuple[float, float]:
        """Return the ball's or a player's position relative to the keeper, in world axes, m."""
        bearing = self.values[percept.HEADING] + self.values[place + 1]
        distance = self.values[place]
        return distance * math.cos(bearing), distance * math.sin(bearing)

    def corner(self, place: int) -> tuple[float, float]:
        """Return the distance of a fixed place, m, and its direction relative to the body, rad."""
        (right, up), (x, y) = self.fixed[place], self.position
        dx = right * self.values[percept.WIDTH] / 2.0 - x
        dy = up * self.values[percept.HEIGHT] / 2.0 - y
        return math.hypot(dx, dy), wrapped(math.atan2(dy, dx) - self.heading)

    def angle_between(self, place: int, other: int) -> float:
        """Return the angle at the keeper between two players, on [0, pi]."""
        return abs(wrapped(self.values[place + 1] - self.values[other + 1]))
