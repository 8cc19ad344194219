"""Interprets what the server lets one player see, or several together.

All figures are the server's: m and m/cycle, y points down, degrees clockwise.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TypeAlias

from keepaway_world.rcss.landmarks import Point, Pose, locate
from keepaway_world.rcss.messages import FullState, PlayerState, See, SeenObject, SenseBody

_LOST = 5.0  # m; an unnumbered player farther from a known player's last position is another one

Who: TypeAlias = tuple[str, int]
"""Side and number of a player."""


class Sighting:
    """What one player knows about the field.

    An object out of sight stays where it was last seen; the ball keeps rolling.

    Args:
        me: side and number.
        teams: side of each team by its name.
        ball_decay, ball_speed_max: of the server.

    Attributes:
        time: of the cycle in which it last saw something; -1: never.
        ball_seen_from: distance at which the ball was seen in this cycle; infinite if it was not.
        kicked: whether it kicked in the last cycle.
    """

    def __init__(
        self, me: Who, teams: Mapping[str, str], ball_decay: float, ball_speed_max: float
    ) -> None:
        self.me = me
        self.time = -1
        self.ball_seen_from = math.inf
        self.kicked = False
        self._teams = teams
        self._decay = ball_decay
        self._speed_max = ball_speed_max
        self._kicks = -1
        self._speed = 0.0, 0.0  # and in which direction off the neck
        self._head = 0.0
        self._pose: Pose | None = None
        self._velocity: Point = 0.0, 0.0
        self._ball = 0.0, 0.0, 0.0, 0.0
        self._players: dict[Who, Point] = {}

    def feel(self, body: SenseBody) -> None:
        """Begin a cycle with what the player feels."""
        self.kicked = 0 <= self._kicks < body.kicks
        self._kicks = body.kicks
        self._speed = body.speed, body.speed_direction
        self._head = body.head_angle
        x, y, vx, vy = self._ball
        self._ball = x + vx, y + vy, vx * self._decay, vy * self._decay
        self.ball_seen_from = math.inf

    def see(self, see: See) -> None:
        """Take in what the player sees in this cycle."""
        pose = locate(see.objects)
        if pose is None:
            return
        self.time = see.time
        self._pose = pose
        amount, direction = self._speed
        along = math.radians(pose[2] + direction)
        self._velocity = amount * math.cos(along), amount * math.sin(along)
        unknown: list[tuple[str, Point]] = []
        known: set[Who] = set()
        for seen in see.objects:
            if math.isnan(seen.distance):
                continue
            match seen.name:
                case ("b",) | ("B",):
                    self._see_ball(seen)
                case ("p", team, number, *_) if number.isdigit() and team in self._teams:
                    who = self._teams[team], int(number)
                    known.add(who)
                    self._players[who] = self._place(seen)
                case ("p", *rest) | ("P", *rest):
                    side = self._teams.get(rest[0], "") if rest else ""
                    unknown.append((side, self._place(seen)))
        self._recognise(unknown, known)

    def _place(self, seen: SeenObject) -> Point:
        assert self._pose is not None
        x, y, neck = self._pose
        angle = math.radians(neck + seen.direction)
        return x + seen.distance * math.cos(angle), y + seen.distance * math.sin(angle)

    def _see_ball(self, seen: SeenObject) -> None:
        assert self._pose is not None
        x, y = self._place(seen)
        expected = self._ball
        if math.isnan(seen.distance_change):
            # Its distance from the expected position is its extra speed.
            vx = expected[2] + (x - expected[0]) * self._decay
            vy = expected[3] + (y - expected[1]) * self._decay
        else:
            angle = math.radians(self._pose[2] + seen.direction)
            across = seen.distance * math.radians(seen.direction_change)
            c, s = math.cos(angle), math.sin(angle)
            vx = self._velocity[0] + seen.distance_change * c - across * s
            vy = self._velocity[1] + seen.distance_change * s + across * c
        if math.hypot(vx, vy) > self._speed_max:  # it was placed there
            vx = vy = 0.0
        self._ball = x, y, vx, vy
        self.ball_seen_from = seen.distance

    def _recognise(self, unknown: Iterable[tuple[str, Point]], known: set[Who]) -> None:
        """Identify players with unreadable numbers by earlier positions."""
        for side, place in unknown:
            candidates = [
                (math.dist(place, was), who)
                for who, was in self._players.items()
                if who not in known and side in ("", who[0])
            ]
            if candidates and (nearest := min(candidates))[0] < _LOST:
                known.add(nearest[1])
                self._players[nearest[1]] = place

    def myself(self) -> PlayerState | None:
        """Return the player's own state; None if not known yet."""
        if self._pose is None:
            return None
        x, y, neck = self._pose
        side, number = self.me
        return PlayerState(side, number, x, y, *self._velocity, neck - self._head, self.kicked)

    def state(self, mode: str) -> FullState | None:
        """Return the field as the player knows it; None if it does not know where it is."""
        myself = self.myself()
        if myself is None:
            return None
        others = (
            PlayerState(*who, *place, 0.0, 0.0, 0.0)
            for who, place in self._players.items()
            if who != self.me
        )
        return FullState(self.time, mode, self._ball, (myself, *others))


def together(sightings: Iterable[Sighting], mode: str) -> FullState | None:
    """Return the field as several players know it together; None if no player knows anything.

    The ball's place is that which the player closest to it sees. Each of these players gives its
    own place; the places of all others are those which the player nearest to the ball gives.
    """
    by_nearness = sorted(sightings, key=lambda sighting: sighting.ball_seen_from)
    states = [state for s in by_nearness if (state := s.state(mode)) is not None]
    if not states:
        return None
    players = {(p.side, p.number): p for state in reversed(states) for p in state.players}
    players |= {(me.side, me.number): me for me, *_ in (state.players for state in states)}
    return replace(states[0], players=tuple(players.values()))
