"""What foragers perceive, and what is refused of parameters and placements."""

import math

import pytest

from foraging_world.body import ForagerBody
from foraging_world.parameters import ForagingParameters
from foraging_world.percept import NOT_SEEN_M
from foraging_world.world import ForagingWorld
from hitab_world.parameters import ParameterError
from hitab_world.world import Placement, WorldError


def test_boxes_are_seen_within_sight_and_not_beyond(quiet, put, sensed):
    world = quiet(small_boxes=1, large_boxes=1)
    put(world, small_box_1=(15.0, 0.0), large_box_1=(-20.0, -20.0), forager_1=(10.0, 0.0, 90.0))
    assert sensed(world, "forager_1", "DistanceTo(closest_box)") == pytest.approx(4.2)
    assert sensed(world, "forager_1", "DirectionTo(closest_box)") == pytest.approx(-math.pi / 2)
    assert sensed(world, "forager_1", "DistanceTo(closest_large_box)") == NOT_SEEN_M
    assert sensed(world, "forager_1", "Sees(closest_large_box)") == 0.0
    put(world, forager_1=(8.1, 0.0))
    assert sensed(world, "forager_1", "Sees(closest_small_box)") == 0.0


def test_a_squad_knows_by_radio_which_box_most_of_it_hold(quiet, put, surround, act, sensed):
    world = quiet(small_boxes=2)
    put(world, small_box_1=(15.0, 0.0), small_box_2=(-15.0, 0.0))
    surround(world, "small_box_1", 1, 1)
    surround(world, "small_box_2", 2, 3)
    world.step(act(world, "Attach(closest_box)", "forager_1", "forager_2", "forager_3"))
    assert [sensed(world, f"forager_{i}", "Holds(squad_box)") for i in (1, 2, 3)] == [0, 1, 1]
    assert sensed(world, "forager_5", "Sees(squad_box)") == 1.0
    assert sensed(world, "forager_6", "Sees(squad_box)") == 0.0
    assert sensed(world, "forager_5", "Sees(company_box)") == 0.0  # it is not a large one
    assert sensed(world, "forager_2", "Hands") == 2.0
    assert sensed(world, "forager_1", "Sees(closest_attached_box)") == 0.0  # by others


def test_the_closest_obstacle_may_be_a_wall(quiet, put, sensed):
    world = quiet()
    put(world, forager_1=(29.0, 0.0, 0.0), forager_2=(28.0, 0.0, 0.0))
    assert sensed(world, "forager_1", "DistanceTo(closest_obstacle)") == pytest.approx(0.8)
    assert sensed(world, "forager_1", "DirectionTo(closest_obstacle)") == pytest.approx(0.0)
    assert sensed(world, "forager_2", "DistanceTo(closest_obstacle)") == NOT_SEEN_M


def test_nobody_walks_through_walls_or_others(quiet, seen):
    world = quiet(foragers=40, width=20.0, height=20.0)
    for _ in range(200):
        world.step({name: ([1.0, 0.0, 0.0], "") for name in world.agents})
    foragers = [seen(world, name) for name in world.agents]
    assert all(max(abs(f.x), abs(f.y)) < 10.0 for f in foragers)
    closest = min(
        math.hypot(a.x - b.x, a.y - b.y) for a in foragers for b in foragers if a is not b
    )
    assert closest > 0.5 * 2 * world.parameters.forager_radius


def test_a_percept_of_another_world_is_refused():
    with pytest.raises(ValueError, match="link the agent to a foraging world"):
        ForagerBody("forager_1").sense([0.0] * 14, [])


def test_parameters_that_cannot_be_are_refused_by_name():
    for figures, message in [
        ({"foragers": 0}, "foragers is 0"),
        ({"foragers": 2.5}, "whole number"),
        ({"width": 5.0}, "at least 10"),
        ({"width": math.nan}, "finite"),
        ({"speed": 0.0}, "above 0"),
        ({"noise": -1.0}, "0 or more"),
        ({"renew": 1}, "true or false"),
        ({"small_pullers": 20}, "do not fit around"),
        ({"foragers": 20_000}, "do not fit into"),
        ({"gravity": 9.81}, 'no foraging parameter "gravity"'),
    ]:
        with pytest.raises(ParameterError, match=message):
            ForagingParameters.from_dict(figures)


@pytest.mark.parametrize("figures", [{"obstacles": 500}, {"small_boxes": 900}])
def test_what_there_is_no_room_for_is_told(figures):
    with pytest.raises(ParameterError, match="no room for"):
        ForagingWorld(ForagingParameters.from_dict(figures))


def test_what_cannot_be_placed_is_told():
    for placement, message in [
        (Placement("home", 1.0, 1.0), "home cannot be moved"),
        (Placement("obstacle_1", 1.0, 1.0), "obstacle_1 cannot be moved"),
        (Placement("forager_1", 31.0, 1.0), "outside the field"),
        (Placement("forager_1", vx=1.0), "velocity cannot be set"),
    ]:
        with pytest.raises(WorldError, match=message):
            ForagingWorld().place([placement])


def test_scouts_see_far_and_tell_their_squad_and_carriers_see_little_and_grip(
    quiet, put, act, sensed
):
    world = quiet(small_boxes=2, foragers=10, scouts=1, scout_sight=12.0, sight=2.0)
    assert world.agents[:6] == ("scout_1", *(f"carrier_{i}" for i in range(1, 5)), "scout_2")
    put(world, small_box_1=(15.0, 0.0), small_box_2=(17.0, 0.0), scout_1=(4.0, 0.0))
    put(world, carrier_1=(14.2, 0.0, 0.0), scout_2=(-9.0, 0.0))
    assert sensed(world, "scout_1", "Sees(closest_box)") == 1.0
    assert sensed(world, "carrier_2", "Sees(closest_box)") == 0.0
    assert sensed(world, "carrier_1", "DistanceTo(scouted_box)") == pytest.approx(0.0)
    assert sensed(world, "carrier_1", "DistanceTo(scout)") == pytest.approx(10.2)
    assert sensed(world, "carrier_5", "Sees(scouted_box)") == 0.0, "another squad"
    world.step(act(world, "Attach(closest_box)", "carrier_1"))
    assert sensed(world, "carrier_1", "Holds(squad_box)") == 1.0
    assert sensed(world, "carrier_2", "Sees(scouted_box)") == 0.0, "that one is held"
    put(world, scout_1=(14.0, 0.6), carrier_1=(0.0, 0.0))
    world.step(act(world, "Attach(closest_box)", "scout_1"))
    assert sensed(world, "scout_1", "HoldsABox") == 0.0
    assert sensed(world, "carrier_1", "DistanceTo(scouted_box)") == pytest.approx(14.2, abs=0.3)
