"""Players that other packages offer: takers for the world, and keepers for comparison.

Entry points of the group ``keepaway.takers`` are called with the world's `Physics` and return
`Takers`. Functions in ``keepaway.keepers`` are called with a `KeepawayWorld` in this process and
return a `hitab_world.inprocess.Player` for each keeper, by name.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any, Protocol

from hitab_core import has
from hitab_world.parameters import ParameterError
from keepaway_world.action import Order
from keepaway_world.game.physics import Physics
from keepaway_world.game.takers import TakerTeam

TAKERS, KEEPERS = "keepaway.takers", "keepaway.keepers"
INTERCEPT = "intercept"
"""The takers of this package."""


class Takers(Protocol):
    """The policy of all takers of a world."""

    def begin(self) -> None:
        """Begin an episode."""

    def decide(self) -> list[Order]:
        """Return the order of each taker for this cycle; its dash power is already slowed."""


def takers_of(physics: Physics, own: Callable[[Physics], Takers] = TakerTeam) -> Takers:
    """Return the takers that the world's parameters name; ``own`` are the game's own takers.

    Raises:
        ParameterError: if no installed package offers them.
    """
    policy = physics.parameters.taker_policy
    takers: Takers = (own if policy == INTERCEPT else offered(TAKERS, policy))(physics)
    return takers


def offered(group: str, name: str) -> Any:
    """Return the players that an installed package offers.

    Raises:
        ParameterError: if no installed package offers this name.
    """
    there = {point.name: point for point in entry_points(group=group)}
    if name not in there:
        known = [*there, *[INTERCEPT] * (group == TAKERS)]
        raise ParameterError(
            f'no installed package offers "{name}" as {group} {has(known, name)}; UT Austin\'s '
            "players are in research/src/keepaway_research of HiTAB's sources"
        )
    return there[name].load()
