"""The freshness of readings: their age, even if stamps are missing or wrong."""

from __future__ import annotations

import math
from collections.abc import Sequence

CLOCK_TOLERANCE_S = 0.1
"""How far a stamp may be ahead of the clock before the two clocks count as different, s."""


class Freshness:
    """The last reading of one sensor, which has values until it is too old.

    A reading is as old as its stamp says. A stamp of zero, or ahead of the clock, says nothing
    about age: the time of arrival counts instead, so that no reading stays fresh for ever. A
    reading with an earlier stamp than the previous one came late and is ignored, unless the
    previous one is too old itself: then the sensor's clock was set back.

    Attributes:
        trouble: the fault of the stamps, as an error text; empty if there is none.
    """

    def __init__(self, count: int, max_age: float, ahead: float = CLOCK_TOLERANCE_S) -> None:
        """Start without a reading.

        Args:
            count: number of values in a reading.
            max_age: age, s, from which on a reading has no values.
            ahead: how far a stamp may be ahead of the clock, s. Infinite in a simulation, which
            has
                one clock: a reading may arrive before the clock's message of the same time.
        """
        self.trouble = ""
        self._none = (math.nan,) * count
        self._max_age = max_age
        self._ahead = ahead
        self._values: Sequence[float] = self._none
        self._stamp = 0.0
        self._measured = self._arrived = -math.inf

    def take(self, values: Sequence[float], stamp: float, now: float) -> bool:
        """Take a reading; return whether it counts.

        Args:
            values: the reading's values.
            stamp: time of the measurement on the sensor's clock, s; 0 if unknown.
            now: time on the clock of this process, s.
        """
        if now < self._arrived:  # the clock was set back, as by a restarted simulation
            self._measured = self._arrived = -math.inf
        known = stamp > 0.0 and math.isfinite(stamp)
        late = known and self._stamp > 0.0 and stamp < self._stamp
        if late and now - self._arrived <= self._max_age:
            return False
        self.trouble = ""
        measured = now
        if known and stamp > now + self._ahead:
            self.trouble = "its stamps are ahead of the clock"
        elif known:
            measured = min(stamp, now)
            if now - measured > self._max_age:
                self.trouble = "its readings are too old when they arrive"
        self._values = values
        self._stamp = stamp if known else 0.0
        self._measured, self._arrived = measured, now
        return True

    def is_fresh(self, now: float) -> bool:
        """Whether the last reading has values."""
        return self._arrived <= now <= self._measured + self._max_age

    def values(self, now: float) -> Sequence[float]:
        """Return the last reading's values; all NaN if it is too old or there is none."""
        return self._values if self.is_fresh(now) else self._none
