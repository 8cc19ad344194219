"""Parts that several tests use."""

import math

import pytest

from foraging_world.body import ForagerBody
from foraging_world.domain import DOMAIN
from foraging_world.parameters import ForagingParameters
from foraging_world.world import ForagingWorld
from hitab_core.running.feature_cache import resolved
from hitab_core.term import Term
from hitab_world.world import Placement


@pytest.fixture
def quiet():
    """Make a world without noise, obstacles and boxes, unless parameters are given."""

    def make(**figures):
        base = {"noise": 0.0, "obstacles": 0, "small_boxes": 0, "large_boxes": 0, "renew": False}
        return ForagingWorld(ForagingParameters.from_dict({**base, **figures}), seed=1)

    return make


@pytest.fixture
def put():
    """Place things by name: ``put(world, small_box_1=(x, y), forager_1=(x, y, degrees))``."""

    def place(world, **places):
        world.place(
            [
                Placement(name, where[0], where[1], math.radians(where[2]))
                if len(where) > 2
                else Placement(name, *where)
                for name, where in places.items()
            ]
        )

    return place


@pytest.fixture
def surround():
    """Put foragers around a box, within reach of it and facing a direction."""

    def around(world, box, first, last, heading=0.0):
        thing = seen(world, box)
        distance = thing.radius + world.parameters.forager_radius + 0.05
        count = last - first + 1
        world.place(
            [
                Placement(
                    f"forager_{first + i}",
                    thing.x + distance * math.cos(2.0 * math.pi * i / count),
                    thing.y + distance * math.sin(2.0 * math.pi * i / count),
                    heading,
                )
                for i in range(count)
            ]
        )
        return [f"forager_{first + i}" for i in range(count)]

    return around


@pytest.fixture
def act():
    """Return what foragers do who perform a basic behavior, such as ``Attach(closest_box)``."""

    def once(world, behavior, *names):
        term = Term.parse(behavior)
        actions = {}
        for name in names:
            body = ForagerBody(name)
            body.sense(*world.percept(name))
            resolved(DOMAIN.behaviors[term.name].pulse, body, DOMAIN, term)()
            actions[name] = body.act()
        return actions

    return once


@pytest.fixture
def sensed():
    """Return the value of a feature for a forager now: ``sensed(world, name, "Holds(home)")``."""

    def value(world, name, feature):
        term = Term.parse(feature)
        body = ForagerBody(name)
        body.sense(*world.percept(name))
        return resolved(DOMAIN.features[term.name].read, body, DOMAIN, term)()

    return value


def seen(world, name):
    """Return an entity by its name."""
    return next(entity for entity in world.entities() if entity.name == name)


@pytest.fixture(name="seen")
def seen_fixture():
    """Return an entity by its name."""
    return seen
