"""What rcssserver's referee does not tell: when an episode began, why it ended, the passes."""

from __future__ import annotations

from collections.abc import Iterable

from keepaway_world import referee
from keepaway_world.physics import Physics
from keepaway_world.rcss.messages import FullState

_AT_REST = 1e-9


class EpisodeWatch:
    """Watches one episode at a time.

    The referee says only that an episode is over, by when it has set up the next one. But it
    checks for a ball that is out before one that is taken, and its count of the takers'
    possession follows from what was seen before; so the reason is known.

    Args:
        rules: the referee of the simulated world, whose rules are the same.
        physics: the field that is kept up to date.

    Attributes:
        began: the server's time when the present episode began.
    """

    def __init__(self, rules: referee.Referee, physics: Physics) -> None:
        self._rules = rules
        self._physics = physics
        self._players = {player.name: player for player in physics.players}
        self.began = 0

    @property
    def passes(self) -> int:
        """How many passes were completed so far."""
        return self._rules.passes

    def begin(self, time: int) -> None:
        """Note that an episode begins, with the field as it is at ``time``."""
        self._rules.begin()
        self.began = time

    def saw(self, kickers: Iterable[str]) -> None:
        """Take note of the field after a cycle, and of who kicked in it."""
        for name in kickers:
            self._rules.saw_kick(self._players[name])
        self._rules.judge(self._physics)

    def why_over(self) -> str:
        """Return why the referee ended the episode in the cycle after the last that was seen."""
        ball, p = self._physics.ball, self._physics.parameters
        out_next = (
            abs(ball.x + ball.vx) >= p.width / 2.0 or abs(ball.y + ball.vy) >= p.height / 2.0
        )
        taken = self._rules.possession >= p.turnover_cycles and not out_next
        return referee.TAKEN if taken else referee.OUT

    def set_up_anew(self, state: FullState) -> bool:
        """Return whether everything stands as when an episode begins, and did not before.

        This tells that an episode has begun where the referee's words were lost.
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
