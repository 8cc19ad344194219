"""Which members owe a commander a report in a lockstep round, and whether all have reported."""

from __future__ import annotations

from collections.abc import Collection, Iterable

PAST = 1 << 20
"""A report fewer rounds back than this is late; further back, the world has restarted its count,
or someone has forged a number."""


class RollCall:
    """Records the reports of one round after the other.

    A member owes a report in each round until it misses one, and again from its next report on. A
    member that missed only rounds of looking owes a report as soon as agents act: a run without
    the member must miss a deadline, which marks the run. No clock is involved: a round is over
    when a later one begins.

    Attributes:
        round: the number of the present round; 0 for real time.
    """

    def __init__(self, members: Collection[str]) -> None:
        self._members = frozenset(members)
        self._owing: set[str] = set()
        self._missing: set[str] = set()
        self._complete = False
        self._looked = False
        self._missed_looks: set[str] = set()
        self.round = 0

    @property
    def missing(self) -> Collection[str]:
        """The members that missed a round and have not reported since."""
        return self._missing

    def begin(self, silent: Iterable[str]) -> None:
        """Switch from real time to lockstep; silent members owe nothing for now."""
        self._owing = set()
        self._missing = set(silent)

    def end(self) -> None:
        """Switch to real time."""
        self.round = 0

    def take(self, member: str, number: int, *, look: bool = False) -> bool:
        """Take a member's report of a round; return whether it makes the round complete.

        In some rounds the agents only ``look``.
        """
        if 0 < self.round - number < PAST:
            self._missing.discard(member)  # it is late, and alive
            return False
        if number != self.round:
            self._missing |= self._owing
            if self._looked:
                self._missed_looks |= self._owing
            if not look:
                self._missing -= self._missed_looks
                self._missed_looks.clear()
            self._looked = look
            self._missing.discard(member)
            self._owing = set(self._members - self._missing)
            self.round, self._complete = number, False
        self._missing.discard(member)
        self._owing.discard(member)
        complete = not (self._complete or self._owing)
        self._complete |= complete
        return complete
