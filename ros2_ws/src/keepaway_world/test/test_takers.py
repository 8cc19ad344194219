"""The takers decide as UT Austin's do, and end keepers' games."""

import csv
import gzip
import math
from pathlib import Path

import pytest

from hitab_world.parameters import ParameterError
from keepaway_world.game.physics import Physics
from keepaway_world.game.takers import TakerTeam
from keepaway_world.parameters import variant
from keepaway_world.world import KeepawayWorld

RECORDED = Path(__file__).parent / "data" / "taker_decisions.csv.gz"


def test_a_taker_decides_as_recorded_on_the_real_simulator():
    parameters = variant("standard", taker_speed=0.25)
    world = Physics(parameters, None)
    team = TakerTeam(world)
    names = {
        "l1": world.keepers[0],
        "l2": world.keepers[1],
        "l3": world.keepers[2],
        "r1": world.takers[0],
        "r2": world.takers[1],
    }
    same_kind = same_amount = cycles = 0
    with gzip.open(RECORDED, "rt") as file:
        for row in csv.DictReader(file):
            value = {key: float(v) for key, v in row.items() if key != "command" and v}
            world.put(
                world.ball,
                value["ball_x"],
                -value["ball_y"],
                0.0,
                value["ball_vx"],
                -value["ball_vy"],
            )
            for name, mover in names.items():
                world.put(
                    mover,
                    value[f"{name}_x"],
                    -value[f"{name}_y"],
                    -math.radians(value[f"{name}_body"]),
                    value[f"{name}_vx"],
                    -value[f"{name}_vy"],
                )
            kind, amount, _ = team.decide()[0]
            amount = -math.degrees(amount) if kind == "turn" else amount
            cycles += 1
            same_kind += kind == row["command"]
            same_amount += abs(math.remainder(amount - value["amount"], 360.0)) < 1.0
    assert cycles > 600
    assert same_kind / cycles > 0.99
    assert same_amount / cycles > 0.98


def play(world, cycles=3000):
    while not world.ended and world.episode_cycle < cycles:
        world.step({})
    return world.result()


@pytest.mark.parametrize("speed", [0.25, 1.0])
def test_takers_take_a_ball_that_nobody_defends(speed):
    for number in range(5):
        world = KeepawayWorld(variant("paper", taker_speed=speed), seed=number)
        assert play(world).ended == "taken"


def test_the_other_taker_waits_facing_the_ball_that_a_team_mate_has(quiet, put):
    world = quiet()
    put(
        world,
        keeper_1=(-9.0, 9.0),
        keeper_2=(9.0, 9.0),
        keeper_3=(9.0, -9.0),
        taker_1=(0.0, 0.0),
        ball=(0.5, 0.0),
        taker_2=(0.0, 4.0, 0.0),
    )
    world.step({})
    world.step({})
    other = next(e for e in world.entities() if e.name == "taker_2")
    assert (other.x, other.y) == (0.0, 4.0)
    assert other.heading == pytest.approx(math.atan2(-4.0, 0.5), abs=1e-6)


def test_takers_that_no_package_offers_are_refused_with_those_that_there_are():
    with pytest.raises(ParameterError, match=r'offers "nobody" as keepaway.takers .*intercept'):
        KeepawayWorld(variant("paper", taker_policy="nobody"))


def test_a_world_can_do_without_takers():
    world = KeepawayWorld(variant("paper", takers=0))
    assert play(world, 200).ended == ""
