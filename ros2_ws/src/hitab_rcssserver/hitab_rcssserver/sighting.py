"""The sighting of a player: the field as one player, or several together, know it from sight.

All numbers are in the server's units and axes: m and m/cycle, y points down, degrees clockwise.
Places and velocities are complex numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TypeAlias

from hitab_rcssserver.landmarks import Pose, away, locate
from hitab_rcssserver.messages import FullState, PlayerState, See, SeenObject, SenseBody

_LOST = 5.0  # m; an unnumbered player farther from a known player's last position is another one

Who: TypeAlias = tuple[str, int]
"""Side and number of a player."""


class Sighting:
    """A player's knowledge of the field.

    A player out of sight counts as standing where it was last seen; a ball keeps rolling.

    Args:
        me: the player's side and number.
        teams: side of each team by its name.
        ball_decay, ball_speed_max: the server's parameters of the ball.

    Attributes:
        time: the last cycle with a sighting; -1 if there was none.
        ball_seen_from: distance at which the ball was seen in this cycle; infinite if unseen.
    """

    def __init__(
        self, me: Who, teams: Mapping[str, str], ball_decay: float, ball_speed_max: float
    ) -> None:
        self.time = -1
        self.ball_seen_from = math.inf
        self._me, self._teams = me, teams
        self._decay, self._speed_max = ball_decay, ball_speed_max
        self._body = SenseBody(-1, 0.0, 0.0, 0.0, -1)
        self._kicked = False
        self._pose: Pose | None = None
        self._velocity = self._ball = self._ball_velocity = 0j
        self._players: dict[Who, complex] = {}

    def feel(self, body: SenseBody) -> None:
        """Begin a cycle with the player's own motion, as reported by the server."""
        self._kicked = 0 <= self._body.kicks < body.kicks
        self._body = body
        self._ball += self._ball_velocity
        self._ball_velocity *= self._decay
        self.ball_seen_from = math.inf

    def see(self, see: See) -> None:
        """Update the knowledge with the objects seen in this cycle."""
        pose = locate(see.objects)
        if pose is None:
            return
        self.time = see.time
        self._pose = place, neck = pose
        self._velocity = away(self._body.speed, neck + self._body.speed_direction)
        unknown: list[tuple[str, complex]] = []
        known: set[Who] = set()
        for seen in see.objects:
            if math.isnan(seen.distance):
                continue
            there = place + away(seen.distance, neck + seen.direction)
            match seen.name:
                case ("b",) | ("B",):
                    self._see_ball(seen, there, neck)
                case ("p", team, number, *_) if number.isdigit() and team in self._teams:
                    who = self._teams[team], int(number)
                    known.add(who)
                    self._players[who] = there
                case ("p", *rest) | ("P", *rest):
                    unknown.append((self._teams.get(rest[0], "") if rest else "", there))
        self._recognise(unknown, known)

    def _see_ball(self, seen: SeenObject, there: complex, neck: float) -> None:
        if math.isnan(seen.distance_change):
            # The ball's distance from the expected position is its extra speed.
            velocity = self._ball_velocity + (there - self._ball) * self._decay
        else:
            turning = seen.distance * math.radians(seen.direction_change)
            relative = complex(seen.distance_change, turning)
            velocity = self._velocity + relative * away(1.0, neck + seen.direction)
        # A ball that seems too fast was placed there.
        self._ball, self._ball_velocity = (
            there,
            0j if abs(velocity) > self._speed_max else velocity,
        )
        self.ball_seen_from = seen.distance

    def _recognise(self, unknown: Iterable[tuple[str, complex]], known: set[Who]) -> None:
        """Identify players with unreadable numbers by earlier positions."""
        for side, place in unknown:
            candidates = [
                (abs(place - was), who)
                for who, was in self._players.items()
                if who not in known and side in ("", who[0])
            ]
            if candidates and (nearest := min(candidates))[0] < _LOST:
                known.add(nearest[1])
                self._players[nearest[1]] = place

    def state(self, mode: str) -> FullState | None:
        """Return the field as the player knows it, itself first; None without its own place."""
        if self._pose is None:
            return None
        place, neck = self._pose
        turned = neck - self._body.head_angle
        states = [PlayerState(*self._me, *_xy(place), *_xy(self._velocity), turned, self._kicked)]
        for who, there in self._players.items():
            if who != self._me:
                states.append(PlayerState(*who, *_xy(there), 0.0, 0.0, 0.0))
        ball = *_xy(self._ball), *_xy(self._ball_velocity)
        return FullState(self.time, mode, ball, tuple(states))


def _xy(value: complex) -> tuple[float, float]:
    return value.real, value.imag


def together(sightings: Iterable[Sighting], mode: str) -> FullState | None:
    """Return the field as several players know it together; None if no player has a sighting.

    The ball's place is the one seen by the player closest to the ball. Each player reports its own
    place; places of other players come from the player nearest to the ball.
    """
    by_nearness = sorted(sightings, key=lambda sighting: sighting.ball_seen_from)
    states = [state for s in by_nearness if (state := s.state(mode)) is not None]
    if not states:
        return None
    players = {(p.side, p.number): p for state in reversed(states) for p in state.players}
    players |= {(me.side, me.number): me for me, *_ in (state.players for state in states)}
    return replace(states[0], players=tuple(players.values()))
