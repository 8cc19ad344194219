"""The random numbers of one agent, which can be looked at ahead and taken up again earlier."""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Callable


class Draws:
    """Draws uniform random numbers on [0, 1) from a seeded generator.

    Attributes:
        count: how many were drawn.
    """

    def __init__(self, seed: int) -> None:
        self.count = 0
        self._random = random.Random()
        self._ahead = deque[float]()
        self.seed(seed)

    def seed(self, seed: int) -> None:
        """Begin with a new seed, as an episode does."""
        self._seed, self._seeded_at = seed, self.count
        self._random.seed(seed)
        self._ahead.clear()

    def __call__(self) -> float:
        """Draw a number."""
        self.count += 1
        return self._ahead.popleft() if self._ahead else self._random.random()

    def ahead(self) -> Callable[[], float]:
        """Return a function that gives the numbers that will be drawn next, and draws none."""
        place = 0

        def look() -> float:
            nonlocal place
            if place == len(self._ahead):
                self._ahead.append(self._random.random())
            place += 1
            return self._ahead[place - 1]

        return look

    def back(self, count: int) -> None:
        """Go on as when this many were drawn, but not before the present seed."""
        self.count, since = max(count, self._seeded_at), self._seeded_at
        self._random.seed(self._seed)
        self._ahead.clear()
        for _ in range(self.count - since):
            self._random.random()
