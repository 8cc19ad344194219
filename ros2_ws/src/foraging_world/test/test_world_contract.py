"""The foraging world keeps what every world promises."""

import math

import pytest

from foraging_world.parameters import ForagingParameters
from foraging_world.world import ForagingWorld
from hitab_world.testing import Wandering, check_world
from hitab_world.world import WorldError

WANDERING = Wandering(
    [[], [1.0, 0.0, 0.0], [1.0, 0.2, 1.0], [1.0, -0.1, 2.0], [-0.5, 0.0, -1.0], [1.0, 0.0, 3.0]]
)
SMALL = {
    "foragers": 12,
    "width": 24.0,
    "height": 24.0,
    "obstacles": 1,
    "large_boxes": 1,
    "large_radius": 1.0,
    "large_pullers": 4,
    "small_pullers": 1,
    "pull_speed": 1.0,
    "duration": 4.5,
}


@pytest.mark.parametrize("figures", [{}, SMALL, {**SMALL, "renew": False, "noise": 0.0}])
def test_foraging_is_a_world(figures):
    check_world(lambda seed: ForagingWorld(ForagingParameters(**figures), seed), WANDERING)


@pytest.mark.parametrize(
    ("key", "damage"),
    [
        ("heading", lambda values: [math.nan, *values[1:]]),
        ("heading", lambda values: values[1:]),
        ("present", lambda values: ["yes" for _ in values]),
        ("held", lambda values: [0.5 for _ in values]),
        ("held", lambda values: [99 for _ in values]),
    ],
)
def test_a_damaged_snapshot_is_refused_and_the_world_stays_as_it_was(key, damage):
    world = ForagingWorld(ForagingParameters(**SMALL))
    kept = world.snapshot()
    world.step(WANDERING.actions(world))
    before = world.snapshot()
    with pytest.raises(WorldError, match=r"the snapshot is damaged: .*; take another one"):
        world.restore({**kept, "field": {**kept["field"], key: damage(kept["field"][key])}})
    assert world.snapshot() == before
