"""A forager's body: what it perceives in this cycle, and what it does."""

from __future__ import annotations

from collections.abc import Sequence

from foraging_world import percept
from foraging_world.action import RELEASE
from foraging_world.percept import FAR, LENGTH


class ForagerBody:
    """The `hitab_core.domain.Body` of one forager.

    Things are referred to by their *place* in the percept: the index of their distance, after
    which their direction and number follow. What a forager does in a cycle is driving, turning
    and gripping; each is set on its own, and is none unless set in this very cycle.

    Attributes:
        values: the percept, laid out as `foraging_world.percept` tells.
    """

    __slots__ = ("_action", "name", "values")

    def __init__(self, name: str) -> None:
        self.name = name
        self.values: Sequence[float] = ()
        self._action = [0.0, 0.0, 0.0]

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take this cycle's percept and forget what was done in the last one.

        Raises:
            ValueError: if the percept is not laid out for a forager.
        """
        if len(values) != LENGTH:
            raise ValueError(
                f"{self.name}: a percept of {len(values)} values is not one of foraging; "
                "is the agent linked to another world?"
            )
        self.values = values
        self._action = [0.0, 0.0, 0.0]

    def act(self) -> tuple[Sequence[float], str]:
        """Return what is done in this cycle, see `foraging_world.action`; foragers are silent."""
        return self._action, ""

    @property
    def position(self) -> tuple[float, float]:
        """Where it is, m."""
        return self.values[percept.X], self.values[percept.Y]

    @property
    def heading(self) -> float:
        """Where its body points, rad."""
        return self.values[percept.HEADING]

    @property
    def held(self) -> float:
        """The number of the box that it holds, 0 if none."""
        return self.values[percept.HELD]

    def sees(self, place: int) -> bool:
        """Whether what a place is about is there and seen, or known by radio."""
        return self.values[place] < FAR

    def drive(self, effort: float) -> None:
        """Walk, or pull if a box is held, along the body; 1 is as fast as it can."""
        self._action[0] = effort

    def turn_by(self, angle: float) -> None:
        """Turn by an angle, rad, or as far as it can in one cycle."""
        self._action[1] = angle

    def grip(self, number: float) -> None:
        """Grip the box of this number, if it is in reach and nothing is held."""
        self._action[2] = number

    def let_go(self) -> None:
        """Let go of the box that is held, if any."""
        self._action[2] = RELEASE
