"""Parts that several tests use."""

import math

import pytest

from hitab_world.world import Placement
from keepaway_world.body import KeeperBody
from keepaway_world.parameters import variant
from keepaway_world.world import KeepawayWorld

NOISELESS = {"movement_noise": 0.0, "kick_noise": 0.0, "turn_noise": 0.0}


@pytest.fixture
def quiet():
    """Make a world without noise, with full sight unless parameters are given."""

    def make(**figures):
        return KeepawayWorld(variant("paper", **{**NOISELESS, "sight": "full", **figures}), seed=1)

    return make


@pytest.fixture
def put():
    """Place things by name: ``put(world, ball=(x, y, vx, vy), keeper_1=(x, y, heading))``."""

    def place(world, **places):
        world.place(
            [
                Placement(name, where[0], where[1], 0.0, *(v * 10.0 for v in where[2:]))
                if name == "ball"
                else Placement(name, where[0], where[1], math.radians((*where, 0.0)[2]), 0.0, 0.0)
                for name, where in places.items()
            ]
        )

    return place


@pytest.fixture
def act():
    """Make one keeper perform a basic behavior; return its action and what it says."""

    def once(world, behavior, name="keeper_1"):
        body = KeeperBody(name, world.parameters)
        body.sense(*world.percept(name))
        behavior(body)
        return body.act()

    return once
