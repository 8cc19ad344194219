"""Keepers that go to where the ball is, not to where it will be.

They are modeled on a keeper recorded on the real simulator, simple enough to derive its rules from
the recording: `ServoKeeper` repeats 623 of its 629 commands. So where its results differ from
those on the real simulator, the worlds differ.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping, Sequence

from hitab_world.inprocess import Player
from keepaway_research.reference.eyes import Eyes
from keepaway_research.reference.keepers import DirectBody
from keepaway_research.reference.positioning import ARRIVED, open_point
from keepaway_research.reference.prediction import FULL
from keepaway_research.reference.view import Seen, View
from keepaway_world.action import Order
from keepaway_world.body import YELL
from keepaway_world.game.angles import PI, wrapped
from keepaway_world.game.kicking import PASS_ARRIVAL_SPEED, off_place
from keepaway_world.world import KeepawayWorld

PRESSED = 5.0  # m: it passes if a taker is nearer
TURN_WHEN_OFF = math.radians(10.0)
AT_REST = 0.1  # m/cycle below which it leaves the ball alone
STOPPING_RATE = 0.02  # m/cycle² per unit of power, its assumption when it stops the ball
CALLED = 15  # cycles for which it goes to the ball after a teammate's call


class ServoKeeper:
    """Decides for one keeper; remembers that it was called.

    Args:
        number: its own, which teammates call out.
    """

    def __init__(self, number: int) -> None:
        self._call = YELL.format(number)
        self.begin()

    def begin(self) -> None:
        """Forget the last episode."""
        self._called = 0

    def decide(self, view: View, heard: Sequence[str]) -> tuple[Order | None, str]:
        """Return the command of a cycle, if any, and what it calls to a teammate."""
        me, ball = view.me, view.ball
        if self._call in heard:
            self._called = CALLED + 1
        elif heard:
            self._called = 0
        self._called = max(self._called - 1, 0)
        if _apart(me, ball) <= view.parameters.kickable:
            self._called = 0
            return self._with_ball(view)
        if self._called or min(view.keepers, key=lambda k: _apart(k, ball)) is me:
            return _go_to(me, complex(ball.x, ball.y)), ""
        return _get_open(view), ""

    def _with_ball(self, view: View) -> tuple[Order | None, str]:
        me, ball = view.me, view.ball
        velocity = complex(ball.vx, ball.vy)
        if not view.takers or min(_apart(taker, me) for taker in view.takers) >= PRESSED:
            if abs(velocity) < AT_REST:
                return None, ""
            power = min(abs(velocity) / STOPPING_RATE, FULL)
            return ("kick", power, wrapped(cmath.phase(-velocity) - me.heading)), ""
        mates = [number for number, keeper in enumerate(view.keepers) if keeper is not me]
        receiver = max(mates, key=lambda number: _openness(view, view.keepers[number]))
        return _pass(view, view.keepers[receiver]), YELL.format(receiver + 1)


def _apart(one: Seen, other: Seen) -> float:
    return math.hypot(one.x - other.x, one.y - other.y)


def _openness(view: View, mate: Seen) -> float:
    """Return the smallest angle at the passer between a teammate and a taker."""

    def direction(player: Seen) -> float:
        return math.atan2(player.y - view.me.y, player.x - view.me.x)

    return min(abs(wrapped(direction(mate) - direction(taker))) for taker in view.takers)


def _pass(view: View, receiver: Seen) -> Order:
    """Return the kick after which the ball arrives at a teammate at 1.2 m/cycle."""
    p, me, ball = view.parameters, view.me, view.ball
    way = complex(receiver.x - ball.x, receiver.y - ball.y)
    speed = PASS_ARRIVAL_SPEED + abs(way) * (1.0 - p.ball_decay)
    acceleration = cmath.rect(speed, cmath.phase(way)) - complex(ball.vx, ball.vy)
    aside = wrapped(math.atan2(ball.y - me.y, ball.x - me.x) - me.heading)
    rate = p.kick_rate * (1.0 - off_place(p, _apart(me, ball), aside))
    power = min(abs(acceleration) / rate, FULL)
    return "kick", power, wrapped(cmath.phase(acceleration) - me.heading)


def _go_to(me: Seen, point: complex) -> Order:
    """Return the turn towards a point, or the dash if it is ahead."""
    off = wrapped(cmath.phase(point - complex(me.x + me.vx, me.y + me.vy)) - me.heading)
    if abs(off) <= TURN_WHEN_OFF:
        return "dash", FULL, 0.0
    return "turn", min(max(off * (1.0 + 5.0 * math.hypot(me.vx, me.vy)), -PI), PI), 0.0


def _get_open(view: View) -> Order:
    p, me, ball = view.parameters, view.me, complex(view.ball.x, view.ball.y)
    takers = [complex(taker.x, taker.y) for taker in view.takers]
    others = [complex(player.x, player.y) for player in view.players if player is not me]
    point = open_point((p.width, p.height), ball, others, takers)
    here = complex(me.x, me.y)
    if abs(point - here) < ARRIVED:
        return "turn", wrapped(cmath.phase(ball - here) - me.heading), 0.0
    return _go_to(me, point)


class SpeakingBody(DirectBody):
    """A body for a player that reads the world directly: it hears, acts and speaks."""

    def __init__(self) -> None:
        super().__init__()
        self.heard: Sequence[str] = ()
        self.say = ""

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take what is heard; the percept is not needed."""
        super().sense(values, heard)
        self.heard, self.say = heard, ""

    def act(self) -> tuple[Sequence[float], str]:
        """Return this cycle's command, and what is said."""
        return super().act()[0], self.say


class ServoPlayer:
    """Plays a keeper that servoes on the ball; see `hitab_world.inprocess.Player`."""

    def __init__(self, world: KeepawayWorld, name: str) -> None:
        self.body = SpeakingBody()
        me = next(k for k in world.physics.keepers if k.name == name)
        self._eyes = Eyes(world.physics, me)
        self._keeper = ServoKeeper(me.index)

    def begin(self, seed: int, episode: int) -> None:
        """Begin an episode; nothing is drawn."""
        self._eyes.begin()
        self._keeper.begin()

    def tick(self) -> None:
        """Decide for this cycle."""
        order, say = self._keeper.decide(self._eyes.view(), self.body.heard)
        if order is not None:
            self._eyes.did(order)
        self.body.order, self.body.say = order, say


def servo_players(world: KeepawayWorld) -> Mapping[str, Player]:
    """Return servo keepers for all keepers of a world, to play in this process."""
    return {name: ServoPlayer(world, name) for name in world.agents}
