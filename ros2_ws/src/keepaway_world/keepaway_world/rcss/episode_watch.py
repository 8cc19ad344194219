"""What rcssserver's referee does not report: an episode's start, end reason and passes."""

from __future__ import annotations

from collections.abc import Iterable

from keepaway_world import referee
from keepaway_world.physics import Physics
from keepaway_world.rcss.messages import FullState

_AT_REST = 1e-9


class EpisodeWatch:
    """Watches one episode at a time.

    The referee only reports that an episode is over, after it has set up the next one. But it
    checks for a ball that is out before one that is taken, and its count of the takers' possession
    follows from earlier cycles, so the reason can be derived.

    Args:
        rules: the referee of the simulated world, which has the same rules.
        physics: the field, which the caller keeps up to date.

    Attributes:
        began: the server's time when the current episode began.
    """

    def __init__(self, rules: referee.Referee, physics: Physics) -> None:
        self._rules = rules
        self._physics = physics
        self._players = {player.name: player for player in physics.players}
        self.began = 0

    @property
    def passes(self) -> int:
        """The number of passes completed so far."""
        return self._rules.passes

    def begin(self, time: int) -> None:
        """Start an episode with the field as it is at ``time``."""
        self._rules.begin()
        self.began = time

    def saw(self, kickers: Iterable[str]) -> None:
        """Record the field after a cycle, and the players that kicked in it."""
        for name in kickers:
            self._rules.saw_kick(self._players[name])
        self._rules.judge(self._physics)

    def why_over(self) -> str:
        """Return why the referee ended the episode in the cycle after the last one seen."""
        ball, p = self._physics.ball, self._physics.parameters
        out_next = (
            abs(ball.x + ball.vx) >= p.width / 2.0 or abs(ball.y + ball.vy) >= p.height / 2.0
        )
        taken = self._rules.possession >= p.turnover_cycles and not out_next
        return referee.TAKEN if taken else referee.OUT

    def set_up_anew(self, state: FullState) -> bool:
        """Return whether the field has just changed to the setup of a new episode.

        This detects a new episode if the referee's message was lost.
        """
        x, y, vx, vy = state.ball
        p = self._physics.parameters
        corner_x, corner_y = referee.KEEPER_CORNERS[0]
        corner_x *= p.width / 2.0 - referee.BALL_INSET
        corner_y *= p.height / 2.0 - referee.BALL_INSET
        there = abs(x - corner_x) < _AT_REST and abs(-y - corner_y) < _AT_REST
        still = all(abs(player.vx) + abs(player.vy) < _AT_REST for player in state.players)
        ball = self._physics.ball
        moved = abs(ball.x - corner_x) + abs(ball.y - corner_y) > _AT_REST
        return there and still and moved and abs(vx) + abs(vy) < _AT_REST
