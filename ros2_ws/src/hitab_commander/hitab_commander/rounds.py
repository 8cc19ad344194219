"""Lockstep rounds: a commander decides at most once in each, independent of any clock.

In each lockstep round, reports pass up the tree and orders pass down it:

1. Every agent perceives and reports to its commander.
2. A commander that has all expected reports perceives, and reports to its superior.
3. A commander that has its superior's order of the round obeys it, decides, and gives its own
   order of the round; the root does not wait.
4. An agent that has its commander's order of the round obeys it, and acts.

So decisions depend only on the reports, not on the timing of messages. For decisions in real time
see `commander_link`.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from hitab_commander.commander_body import CommanderBody
from hitab_commander.kinds.kind_reader import TIME_MAX_S
from hitab_core.orders import Report

DECISIONS_MAX = 600
"""How many cycles with decisions are kept, for a world that goes back: a minute at 10 Hz."""


@dataclass(frozen=True, slots=True)
class Round:
    """A round of reports: the fields that all of them share.

    Attributes:
        number: number of the round.
        cycle: the world's cycle; the smallest one if there are several worlds.
        seconds: the subordinates' own time, s.
        seed, episode: seed of the run, and number of the episode.
        look: whether no agent acts in this round.
        restart: whether an episode begins.
        back: whether the world went back to the cycle.
    """

    number: int
    cycle: int
    seconds: float
    seed: int
    episode: int
    look: bool
    restart: bool
    back: bool


class Lockstep:
    """Takes reports; determines when a round is complete and whether to decide in it."""

    def __init__(self, body: CommanderBody) -> None:
        self._body = body
        self._news = True
        self._began_at = 0.0
        self._period = -1
        self._decided = deque[int](maxlen=DECISIONS_MAX)

    @property
    def active(self) -> bool:
        """Whether the subordinates' world is in lockstep."""
        return bool(self._body.roll.round)

    def hear(self, report: Report, now: float) -> tuple[bool, Round | None]:
        """Take a report.

        Returns:
            Whether more than values has changed, and the round if it is complete now.
        """
        body = self._body
        changed = body.hear(report, now)
        self._news |= changed
        if not report.round or report.agent not in body.members:
            return changed, None
        complete = body.roll.take(report.agent, report.round, look=report.look)
        return changed, self._round() if complete else None

    def _round(self) -> Round:
        reports = [report for _, report in self._body.present()]
        first = reports[0]
        return Round(
            self._body.roll.round,
            min(report.cycle for report in reports),
            first.seconds,
            first.seed,
            first.episode,
            all(report.look for report in reports),
            any(report.restart for report in reports),
            any(report.back for report in reports),
        )

    def expect(self) -> None:
        """Decide in the next round whatever the reports are; called after an order or command."""
        self._news = True

    def is_due(self, present: Round) -> bool:
        """Return whether a decision is due in a round; call this once a round.

        A decision is due when something has changed, and at the commander's rate, counted in the
        subordinates' time from the beginning of the episode.
        """
        if present.restart and not present.look:
            self._began_at = present.seconds
        seconds = present.seconds - self._began_at
        # Times are sums of cycles, so tolerate their rounding errors.
        period = int((seconds + 1.0 / TIME_MAX_S) * self._body.kind.rate)
        if present.look:
            self._news |= present.restart
            if present.back:  # a decision is due again in this cycle if one was
                self._news, self._period = present.cycle in self._decided, period
            return False
        due = self._news or present.restart or period != self._period
        self._news, self._period = False, period
        while self._decided and self._decided[-1] >= present.cycle:
            self._decided.pop()
        if due:
            self._decided.append(present.cycle)
        return due and self._body.ready
