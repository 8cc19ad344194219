"""A forager's body: its percept of this cycle, and its action."""

from __future__ import annotations

from collections.abc import Sequence

from foraging_world import percept
from foraging_world.action import RELEASE
from foraging_world.percept import NOT_SEEN_M, PERCEPT_LENGTH
from hitab_core import quantity


class ForagerBody:
    """The `hitab_core.domain.Body` of one forager.

    Things are referred to by their *place* in the percept: the index of their distance, which is
    followed by their direction and number. A forager drives, turns and grips; each of these is
    set separately and lasts for one cycle.

    Attributes:
        values: the percept, in the layout of `foraging_world.percept`.
    """

    __slots__ = ("_action", "name", "values")

    def __init__(self, name: str) -> None:
        self.name = name
        self.values: Sequence[float] = ()
        self._action = [0.0, 0.0, 0.0]

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take this cycle's percept and clear the last action.

        Raises:
            ValueError: if the percept does not have a forager's layout.
        """
        if len(values) != PERCEPT_LENGTH:
            raise ValueError(
                f"{self.name}: a percept of {quantity(len(values), 'value')} is not from "
                f"foraging, which has {PERCEPT_LENGTH}; link the agent to a foraging world"
            )
        self.values = values
        self._action = [0.0, 0.0, 0.0]

    def act(self) -> tuple[Sequence[float], str]:
        """Return this cycle's action, see `foraging_world.action`; foragers say nothing."""
        return self._action, ""

    @property
    def position(self) -> tuple[float, float]:
        """The forager's position, m."""
        return self.values[percept.X], self.values[percept.Y]

    @property
    def heading(self) -> float:
        """The direction of the forager's body, rad."""
        return self.values[percept.HEADING]

    @property
    def held(self) -> float:
        """The number of the held box, 0 if none."""
        return self.values[percept.HELD]

    def sees(self, place: int) -> bool:
        """Return whether the thing at a place is seen, or known by radio."""
        return self.values[place] < NOT_SEEN_M

    def drive(self, effort: float) -> None:
        """Walk, or pull if a box is held, along the body; 1 is full speed."""
        self._action[0] = effort

    def turn_by(self, angle: float) -> None:
        """Turn by an angle, rad, limited to the maximum of one cycle."""
        self._action[1] = angle

    def grip(self, number: float) -> None:
        """Grip the box with this number, if it is in reach and nothing is held."""
        self._action[2] = number

    def let_go(self) -> None:
        """Let go of the box that is held, if any."""
        self._action[2] = RELEASE
