"""The roll call of a lockstep round: which members must report, and whether all have."""

from __future__ import annotations

from collections.abc import Collection, Iterable

LATE_ROUNDS_MAX = 1 << 20
"""A report of fewer rounds ago than this is late. A report of an even earlier round means that the
world has restarted its count, or that a number was forged."""


class RollCall:
    """Records the reports of each lockstep round.

    A member is expected to report in each round until it misses one, and again after its next
    report. A member that missed only look-only rounds, in which agents perceive and do not act, is
    expected again as soon as agents act. So a run without the member misses at least one deadline,
    which marks the run as not reproducible. No clock is involved: a round is over when a later one
    begins.

    Attributes:
        round: the number of the present round; 0 for real time.
    """

    def __init__(self, members: Collection[str]) -> None:
        self._members = frozenset(members)
        self._expected: set[str] = set()
        self._missing: set[str] = set()
        self._complete = False
        self._last_was_look = False
        self._missed_looks: set[str] = set()
        self.round = 0

    @property
    def missing(self) -> Collection[str]:
        """The members that missed a round and have not reported since."""
        return self._missing

    def begin(self, silent: Iterable[str]) -> None:
        """Switch from real time to lockstep; silent members are not expected to report yet."""
        self._expected = set()
        self._missing = set(silent)

    def end(self) -> None:
        """Switch to real time."""
        self.round = 0

    def take(self, member: str, number: int, *, look: bool = False) -> bool:
        """Take a member's report of a round; return whether it makes the round complete.

        ``look`` marks a look-only round.
        """
        if 0 < self.round - number < LATE_ROUNDS_MAX:
            self._missing.discard(member)  # a late report shows that the member is alive
            return False
        if number != self.round:
            self._missing |= self._expected
            if self._last_was_look:
                self._missed_looks |= self._expected
            if not look:
                self._missing -= self._missed_looks
                self._missed_looks.clear()
            self._last_was_look = look
            self._missing.discard(member)
            self._expected = set(self._members - self._missing)
            self.round, self._complete = number, False
        self._missing.discard(member)
        self._expected.discard(member)
        complete = not (self._complete or self._expected)
        self._complete |= complete
        return complete
