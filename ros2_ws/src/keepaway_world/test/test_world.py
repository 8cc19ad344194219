"""The world as those who drive it see it: seeds, snapshots, placing, and bad input."""

import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hitab_world.parameters import ParameterError
from hitab_world.world import Placement, WorldError
from keepaway_world.parameters import (
    PAPER,
    KeepawayParameters,
    variant,
)
from keepaway_world.world import KeepawayWorld


def wander(world, cycles):
    """Let the keepers do varied things; return all that happens."""
    happened = []
    for _ in range(cycles):
        if world.ended:
            world.reset()
        n = world.episode_cycle
        actions = {
            "keeper_1": ([1.0, 60.0 + n % 40], "" if n % 7 else f"pass {n % 3 + 1}"),
            "keeper_2": ([2.0, 0.4 * (n % 5)], "" if n % 14 else "hello"),
            "keeper_3": ([3.0, 50.0, 0.3] if n % 2 else [1.0, 90.0], ""),
        }
        happened.append(world.step(actions))
        happened.append(world.entities())
        happened.extend(world.percept(name) for name in world.agents)
        happened.append(world.result())
    return happened


def test_an_episode_starts_the_same_with_every_version_of_python():
    world = KeepawayWorld(seed=1)
    assert world.entities()[1].x == pytest.approx(7.453340158941588, abs=1e-12)


@settings(max_examples=15)
@given(st.integers(0, 80), st.integers(0, 1000))
def test_a_restored_world_goes_on_as_if_nothing_had_happened(cycles, seed):
    world = KeepawayWorld(variant("standard"), seed=seed)
    wander(world, cycles)
    kept = json.loads(json.dumps(world.snapshot()))
    expected = wander(world, 40)
    world.restore(kept)
    assert wander(world, 40) == expected
    fresh = KeepawayWorld(variant("standard"), seed=seed + 1)
    fresh.restore(kept)
    assert wander(fresh, 40) == expected


def test_a_snapshot_damaged_within_a_part_is_refused_as_a_whole():
    for part, key, value in [
        ("movers", "taker_1", [0.0, math.nan, 0.0, 0.0, 0.0]),
        ("movers", "taker_1", [0.0, 0.0]),
        ("referee", "last_kick", "keeper_9"),
        ("referee", "stuck_at", [0.0]),
        ("referee", "possession", None),
    ]:
        world = KeepawayWorld(seed=4)
        kept = world.snapshot()
        wander(world, 30)
        before = world.snapshot()
        with pytest.raises(WorldError, match="the snapshot is damaged"):
            world.restore({**kept, part: {**kept[part], key: value}})
        assert world.snapshot() == before


def test_placing_moves_what_is_named_and_keeps_what_is_not_given():
    world = KeepawayWorld(seed=2)
    before = {e.name: e for e in world.entities()}
    world.place([Placement("keeper_2", x=1.5), Placement("ball", 2.0, 3.0, vx=4.0)])
    after = {e.name: e for e in world.entities()}
    assert after["keeper_2"].x == 1.5
    assert after["keeper_2"].y == before["keeper_2"].y
    assert after["keeper_2"].heading == pytest.approx(before["keeper_2"].heading)
    assert (after["ball"].x, after["ball"].vx, after["ball"].vy) == (2.0, pytest.approx(4.0), 0.0)
    assert after["taker_1"] == before["taker_1"]


def test_nothing_is_placed_if_anything_is_refused():
    for placement, message in [
        (Placement("goalie", 0.0, 0.0), 'nothing is called "goalie"'),
        (Placement("ball", math.inf, 0.0), "ball: a value is infinite"),
        (Placement("ball", 0.0, -1e308), r"ball: \(0, -1e\+308\) m is beyond 1000 m"),
        (Placement("keeper_1", vx=30.0), "keeper_1: a speed of 30.00 m/s"),
    ]:
        world = KeepawayWorld()
        before = world.snapshot()
        with pytest.raises(WorldError, match=message):
            world.place([Placement("ball", 0.0, 0.0), placement], new_episode=True)
        assert world.snapshot() == before


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (([1.0, math.nan], ""), "finite"),
        (([7.0, 1.0], ""), "unknown kind of action"),
        (([3.0, 50.0], ""), "a kick has 3 values"),
        ((["dash", 100.0], ""), "unknown kind of action"),
        (None, "treated as no action"),
    ],
)
def test_a_bad_action_is_named_and_counts_as_none(quiet, action, message):
    world, idle = quiet(), quiet()
    idle.step({})
    world.step({"keeper_2": action})
    assert message in world.refused["keeper_2"]
    assert world.refused["keeper_2"].startswith("keeper_2: ")
    assert world.entities() == idle.entities()
    world.step({})
    assert world.refused == {}


def test_an_action_of_a_stranger_is_named():
    world = KeepawayWorld()
    world.step({"keeper_9": ([1.0, 100.0], "")})
    assert 'no agent "keeper_9"' in world.refused["keeper_9"]
    with pytest.raises(WorldError, match="keeper_9"):
        world.percept("keeper_9")


def test_a_message_too_long_is_not_heard_but_the_command_is_performed():
    world = KeepawayWorld()
    x = world.entities()[1].x
    world.step({"keeper_1": ([1.0, 100.0], "x" * 11)})
    assert "at most 10 characters" in world.refused["keeper_1"]
    assert world.percept("keeper_2")[1] == []
    assert world.entities()[1].x != x


def test_of_several_messages_each_hears_one_and_nobody_hears_itself():
    world = KeepawayWorld()
    world.step({name: ([], f"I am {name[-1]}") for name in world.agents})
    for name in world.agents:
        (message,) = world.percept(name)[1]
        assert message != f"I am {name[-1]}"


def test_passes_are_measured(quiet, put):
    world = quiet()
    put(world, keeper_1=(0.0, 0.0), keeper_2=(0.0, 1.5), ball=(0.0, 0.7))
    kick = ([3.0, 1.0, 0.0], "")
    world.step({"keeper_1": kick})
    world.step({"keeper_2": kick})
    assert world.result().measures == {"passes": 1.0}


def test_parameters_that_cannot_be_are_refused_by_name():
    for figures, message in [
        ({"keepers": 1}, "keepers is 1"),
        ({"takers": -1}, "takers is -1"),
        ({"keepers": 2.5}, "whole number"),
        ({"width": 3.0}, "at least 12"),
        ({"ball_decay": 1.0}, "between 0 and 1"),
        ({"taker_speed": -0.5}, "must not be negative"),
        ({"ball_radius": math.nan}, "must be finite"),
        ({"sight": "blurred"}, "one of: quantised, full"),
        ({"ball_collides": 1}, "true or false"),
        ({"gravity": 9.81}, 'no keepaway parameter "gravity"'),
    ]:
        with pytest.raises(ParameterError, match=message):
            KeepawayParameters.from_dict(figures)


def test_named_variants_can_be_changed():
    assert variant("paper") == PAPER
    changed = variant("standard", takers=3)
    assert (changed.taker_speed, changed.ball_collides, changed.takers) == (1.0, True, 3)
    with pytest.raises(ParameterError, match="paper, standard"):
        variant("indoor")
