"""Keepaway keeps what every world promises."""

import pytest

from hitab_world.testing import Wandering, check_world
from keepaway_world.parameters import variant
from keepaway_world.world import KeepawayWorld

WANDERING = Wandering(
    [[], [1.0, 100.0], [1.0, 60.0], [2.0, 0.5], [2.0, -2.0], [3.0, 60.0, 1.0], [3.0, 20.0, -2.0]],
    say=["pass 2", "hello"],
)


@pytest.mark.parametrize("name", ["paper", "standard"])
def test_keepaway_is_a_world(name):
    check_world(lambda seed: KeepawayWorld(variant(name), seed), WANDERING)
