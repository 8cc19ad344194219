"""The state of a server's game, cycle by cycle, with reasons that its referee does not report.

In keepaway, the server's referee only reports that an episode is over, after it has set up the
next one. It has checked for a ball that is out before one that is taken, and has counted the
takers' possession from earlier cycles. Our referee of the simulated world has the same rules, and
gives the reason. In a match, the server's referee stops play with a reason; all other reasons come
from our referee.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from hitab_rcssserver.field import ReportedField
from hitab_rcssserver.link import Link
from hitab_rcssserver.messages import BEFORE_KICK_OFF, EPISODE_OVER, PLAYING, FullState
from hitab_world import Sensed
from keepaway_world import referee
from keepaway_world.game.arranging import Place
from keepaway_world.game.rules import Rules
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.percept import perceive

_AT_REST = 1e-9


@dataclass(frozen=True, slots=True)
class Turn:
    """The state of a cycle, and the events since the previous cycle.

    Attributes:
        state: the current field; None if the message was lost.
        passed: number of cycles since; more than one if the server did not wait for us.
        episode_cycle: length of the episode so far.
        measures: measures of the episode so far.
        ended: reason for the episode's end; "" during the episode.
        began: whether a new episode has begun.
    """

    state: FullState | None
    passed: int
    episode_cycle: int
    measures: Mapping[str, float]
    ended: str
    began: bool


class ReportedGame:
    """A game, as reported to its players.

    Args:
        parameters: parameters of the server's game.
        rules: rules of the game.
        by_sight: whether keepers perceive their own sight, instead of the true field.

    Attributes:
        field: the current field.
        agents: the keepers.
        mode: the server's play mode.
        time: the server's time in cycles; -1 if not known yet.
    """

    def __init__(self, parameters: KeepawayParameters, rules: Rules, *, by_sight: bool) -> None:
        self.field = ReportedField(parameters, rules)
        self.agents = tuple(keeper.name for keeper in self.field.physics.keepers)
        self.mode = ""
        self.time = -1
        exact = replace(parameters, sight="full")  # the server has already rounded what is seen
        self._seen = (
            {name: ReportedField(exact, rules) for name in self.agents} if by_sight else {}
        )
        self._stops = rules.stops
        self._referee = rules.referee(self.field.physics)
        self._began = 0
        self._heard: dict[str, list[str]] = {}

    @property
    def fresh(self) -> bool:
        """Whether the current episode has not been played yet."""
        return self.time == self._began

    def measures(self, ended: str) -> dict[str, float]:
        """Return the measures of the current episode so far."""
        return self._referee.measures(ended)

    def begin(self, time: int | None = None) -> None:
        """Start an episode from the current field."""
        self._referee.begin()
        self.mode = PLAYING
        self._began = self.time if time is None else time

    def take(self, link: Link) -> Turn:
        """Take in a cycle's messages to the players."""
        passed = max(link.time - self.time, 0) if self.time >= 0 else 0
        self.time = link.time
        states = link.states()  # several if we were late
        state = states[-1] if states else None  # None if lost: the field then stays unchanged
        mode = state.mode if state is not None else self.mode
        said = [when for when, text in link.referee if text == EPISODE_OVER]
        # Of several cycles, use the time of the message.
        at = max(said, default=self.time)
        before = (s for s in states[:-1] if s.time < at)
        judged = [self._judge(s) for s in before if s.mode == self.mode == PLAYING]
        over = bool(said)
        if state is not None and self.mode == mode == PLAYING and not self._stops:
            over = over or self._set_up_anew(state)
        began = over or (mode == PLAYING and self.mode == BEFORE_KICK_OFF)
        ended = self._why_over() if over else ""
        if state is not None and (began or mode != PLAYING):
            self.field.take(state)
        elif state is not None:
            judged.append(self._judge(state))
        if self._stops:
            ended = next(filter(None, judged), "")
        if self._stops and self.mode == PLAYING != mode:
            ended = next((why for stop, why in self._stops if mode.startswith(stop)), mode)
        episode_cycle, measures = at - self._began, self.measures(ended)
        if began:
            self.begin(at)
        for name, field in self._seen.items():
            sighting = link.clients[name].sighting
            if sighting is not None and (seen := sighting.state(mode)) is not None:
                field.take(seen)
        self._heard = {name: list(client.heard) for name, client in link.clients.items()}
        self.mode = mode
        return Turn(state, passed, episode_cycle, measures, ended, began)

    def _judge(self, state: FullState) -> str | None:
        """Adopt a cycle's state; return why the episode ended with it, "" if it continues."""
        for kicker in self.field.take(state):
            self._referee.saw_kick(kicker)
        return self._referee.judge(self.field.physics)

    def _why_over(self) -> str:
        """Return why the server's referee ended the episode in the cycle after the last report."""
        ball, p = self.field.physics.ball, self.field.physics.parameters
        across, along = abs(ball.x + ball.vx), abs(ball.y + ball.vy)
        out = across >= p.width / 2.0 or along >= p.height / 2.0
        taken = self._referee.possession >= p.turnover_cycles and not out
        return referee.TAKEN if taken else referee.OUT

    def _set_up_anew(self, state: FullState) -> bool:
        """Return whether the field has just changed to the setup of a new episode.

        The setup shows that an episode has begun even if the referee's message was lost.
        """
        x, y, vx, vy = state.ball
        ball = self.field.physics.ball
        corner_x, corner_y = referee.ball_start(self.field.physics.parameters)
        there = abs(x - corner_x) + abs(-y - corner_y) < _AT_REST
        speeds = [abs(vx) + abs(vy), *(abs(p.vx) + abs(p.vy) for p in state.players)]
        moved = abs(ball.x - corner_x) + abs(ball.y - corner_y) > _AT_REST
        return there and moved and max(speeds) < _AT_REST

    def percept(self, keeper: str) -> Sensed:
        """Return a keeper's percept."""
        field = self._seen.get(keeper, self.field)
        return perceive(field.physics, field.movers[keeper]), list(self._heard.get(keeper, ()))

    def put(self, places: Mapping[str, Place]) -> None:
        """Record that things were placed."""
        for field in (self.field, *self._seen.values()):
            field.put(places)
