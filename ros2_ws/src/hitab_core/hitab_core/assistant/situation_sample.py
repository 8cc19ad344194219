"""The situations that an agent in training met: a bounded sample in which every kind has a place.

A situation that lasts a second matters as much as one that lasts hours: the agent must decide in
both. So moments are sorted into kinds, which differ in the state or in boolean or categorical
values, and each kind keeps a random sample of its own.

Source: J. S. Vitter, Random sampling with a reservoir, ACM Transactions on Mathematical Software
11, 1985, algorithm R.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import replace
from random import Random

from hitab_core.training.percepts import PerceptRecord

SITUATIONS_MAX = 400
"""The most moments that are kept; with more, looking for questions takes long."""


class SituationSample:
    """A sample of the moments that were met."""

    def __init__(self) -> None:
        self._kinds: dict[Hashable, list[PerceptRecord]] = {}
        self._seen: dict[Hashable, int] = {}
        self._random = Random(0)

    def __iter__(self) -> Iterator[PerceptRecord]:
        """Iterate over the sample."""
        return (moment for kind in self._kinds.values() for moment in kind)

    def add(self, kind: Hashable, moment: PerceptRecord) -> None:
        """Add a moment; it may take the place of another one, or of none.

        Args:
            kind: moments of different kinds do not replace each other, unless one has many.
            moment: the percept.
        """
        sample = self._kinds.setdefault(kind, [])
        self._seen[kind] = self._seen.get(kind, 0) + 1
        if sum(map(len, self._kinds.values())) >= SITUATIONS_MAX:
            largest = max(self._kinds.values(), key=len)
            if len(sample) == len(largest):
                place = self._random.randrange(self._seen[kind])
                if place < len(sample):
                    sample[place] = moment
                return
            largest.pop(self._random.randrange(len(largest)))
        sample.append(moment)

    @property
    def news(self) -> tuple[int, int]:
        """Counter that changes with each new kind, and whenever the number met doubles."""
        return len(self._kinds), sum(self._seen.values()).bit_length()

    def go_back(self, cycle: int) -> None:
        """Have situations of later cycles count for no cycle: the world plays these again."""
        for sample in self._kinds.values():
            sample[:] = [m if m.cycle < cycle else replace(m, cycle=0) for m in sample]

    def forget_from(self, time: float) -> None:
        """Forget situations met from some time on, s."""
        for sample in self._kinds.values():
            sample[:] = [moment for moment in sample if moment.time < time]
