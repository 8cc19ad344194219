"""Boxes move when enough foragers pull, and count when they come home."""

import math

import pytest

from hitab_world.world import Placement, WorldError


def pull(world, names, act, cycles=1):
    for _ in range(cycles):
        world.step(act(world, "Forward", *names))


def grip(world, names, act):
    world.step(act(world, "Attach(closest_box)", *names))


@pytest.mark.parametrize(("size", "needed"), [("small", 5), ("large", 25)])
def test_a_box_moves_when_enough_foragers_pull(quiet, put, surround, act, seen, size, needed):
    world, box = quiet(**{f"{size}_boxes": 1}), f"{size}_box_1"
    put(world, **{box: (15.0, 0.0)})
    names = surround(world, box, 1, needed, heading=0.0)
    grip(world, names, act)
    pull(world, names[1:], act, cycles=5)
    assert (seen(world, box).x, seen(world, box).y) == (15.0, 0.0)
    pull(world, names, act, cycles=10)
    assert seen(world, box).x == pytest.approx(15.0 + 10 * 0.05)
    assert seen(world, box).y == pytest.approx(0.0)


def test_foragers_who_pull_in_opposite_directions_go_nowhere(quiet, put, surround, act, seen):
    world = quiet(small_boxes=1)
    put(world, small_box_1=(15.0, 0.0))
    names = surround(world, "small_box_1", 1, 6, heading=0.0)
    grip(world, names, act)
    world.place([])  # nothing: those who hold on are not disturbed
    for _ in range(16):  # three of them turn around
        world.step({name: ([0.0, 0.2, 0.0], "") for name in names[:3]})
    before = seen(world, "small_box_1").x
    pull(world, names, act, cycles=10)
    assert seen(world, "small_box_1").x == pytest.approx(before, abs=0.02)


def test_who_holds_a_box_goes_where_it_goes(quiet, put, surround, act, seen):
    world = quiet(small_boxes=1)
    put(world, small_box_1=(15.0, 0.0))
    names = surround(world, "small_box_1", 1, 6)
    grip(world, names, act)
    before = seen(world, "forager_6")
    pull(world, names[:5], act, cycles=10)
    after = seen(world, "forager_6")
    assert (after.x - before.x, after.y - before.y) == (pytest.approx(0.5), pytest.approx(0.0))


def test_a_box_that_comes_home_counts_and_is_let_go(quiet, put, surround, act, sensed, seen):
    world = quiet(small_boxes=1)
    put(world, small_box_1=(-6.0, 0.0))
    names = surround(world, "small_box_1", 1, 5, heading=0.0)
    grip(world, names, act)
    cycles = 0
    while not world.ended:
        pull(world, names, act)
        cycles += 1
        assert cycles < 60
    assert world.ended == "cleared"
    assert world.result().measures == {"boxes": 1.0, "small": 1.0, "large": 0.0, "pullers": 5.0}
    assert all(sensed(world, name, "HoldsABox") == 0.0 for name in names)
    assert "small_box_1" not in {entity.name for entity in world.entities()}
    with pytest.raises(WorldError, match="home already"):
        world.place([Placement("small_box_1", 10.0, 0.0)])


def test_who_is_out_of_reach_or_holds_another_box_grips_nothing(quiet, put, act, sensed):
    world = quiet(small_boxes=2)
    put(world, small_box_1=(15.0, 0.0), small_box_2=(15.0, 1.9), forager_1=(13.8, 0.0, 0.0))
    grip(world, ["forager_1"], act)
    assert sensed(world, "forager_1", "HoldsABox") == 0.0
    put(world, forager_1=(15.0, 0.95, 90.0))
    assert sensed(world, "forager_1", "CanGrip(closest_box)") == 1.0
    world.step({"forager_1": ([0.0, 0.0, 2.0], "")})
    world.step({"forager_1": ([0.0, 0.0, 1.0], "")})
    assert world.percept("forager_1")[0][4] == 2.0


def test_waiting_and_resting_are_timed(quiet, put, act, sensed):
    world = quiet(small_boxes=1)
    put(world, small_box_1=(15.0, 0.0), forager_1=(14.1, 0.0, 0.0))
    assert sensed(world, "forager_1", "Rested") == 1000.0
    grip(world, ["forager_1"], act)
    pull(world, ["forager_1"], act, cycles=9)
    assert sensed(world, "forager_1", "Waited") == pytest.approx(1.0)
    world.step(act(world, "Release", "forager_1"))
    pull(world, [], act, cycles=9)
    assert sensed(world, "forager_1", "Waited") == 0.0
    assert sensed(world, "forager_1", "Rested") == pytest.approx(1.0)


def test_a_pulled_box_slides_around_an_obstacle(quiet, surround, act, seen):
    world = quiet(small_boxes=1, obstacles=1, noise=0.05)
    obstacle = seen(world, "obstacle_1")
    away = math.hypot(obstacle.x, obstacle.y)
    beyond = (away + 4.0) / away
    world.place([Placement("small_box_1", obstacle.x * beyond, obstacle.y * beyond)])
    names = surround(world, "small_box_1", 1, 5, heading=math.atan2(-obstacle.y, -obstacle.x))
    grip(world, names, act)
    for _ in range(2000):
        if world.ended:
            break
        actions = act(world, "TurnTo(home)", *names)
        world.step({name: ([1.0, *values[1:]], say) for name, (values, say) in actions.items()})
        for name in names:
            forager = seen(world, name)
            gap = math.hypot(forager.x - obstacle.x, forager.y - obstacle.y)
            assert gap > obstacle.radius + forager.radius - 0.1
    assert world.ended == "cleared"
