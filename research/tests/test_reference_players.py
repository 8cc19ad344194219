"""UT Austin's players decide as recorded on the real simulator, and play whole episodes."""

import csv
import gzip
import math
from collections import Counter
from pathlib import Path
from random import Random

import pytest

from hitab_world.inprocess import play
from keepaway_research.reference.eyes import Eyes
from keepaway_research.reference.keepers import ReferenceKeeper
from keepaway_research.reference.policies import hand
from keepaway_research.reference.takers import ReferenceTaker
from keepaway_world.game.physics import Physics
from keepaway_world.game.players import KEEPERS, offered
from keepaway_world.parameters import variant
from keepaway_world.world import KeepawayWorld

DATA = Path(__file__).parent / "data"
UT = variant("standard", taker_policy="reference", sight="quantised")


def recorded(what: str):
    """Yield the state and what each player did in it, cycle by cycle; y up, angles in rad."""
    with gzip.open(DATA / f"ut_decisions_{what}.csv.gz", "rt") as file:
        yield from csv.DictReader(file)


def show(row, world: Physics) -> dict:
    """Put everybody where a row says; return the players by their recorded names."""

    def at(name, *fields):
        return [float(row[f"{name}_{field}"]) for field in fields]

    x, y, vx, vy = at("ball", "x", "y", "vx", "vy")
    world.put(world.ball, x, -y, 0.0, vx, -vy)
    recorded = [field.partition("_")[0] for field in row if field.endswith("_body")]
    names = dict(zip(recorded, world.players, strict=True))
    for name, player in names.items():
        x, y, vx, vy, body = at(name, "x", "y", "vx", "vy", "body")
        world.put(player, x, -y, -math.radians(body), vx, -vy)
    return names


def command(row, name):
    """Return the recorded command as the players of this package give it."""
    kind, amount = row[f"{name}_command"], float(row[f"{name}_amount"])
    direction = -math.radians(float(row[f"{name}_direction"] or 0.0))
    return kind, -math.radians(amount) if kind == "turn" else amount, direction


def agree(one, other, tolerance) -> bool:
    """Whether two commands are the same within so many units of power and degrees."""
    if one[0] != other[0]:
        return False
    amount = one[1] - other[1]
    if one[0] == "turn":
        amount = math.degrees(math.remainder(amount, 2.0 * math.pi))
    direction = math.degrees(math.remainder(one[2] - other[2], 2.0 * math.pi))
    return abs(amount) <= tolerance and abs(direction) <= tolerance


def agreement(what, slowed, tolerance, **game):
    """Return the parts of decisions that are as recorded: keeping, taking, and marking."""
    figures = variant("standard", **game)
    world = Physics(figures, Random(0))
    eyes, minds = {}, {}
    same, decisions = Counter(), Counter()
    episode = None
    for row in recorded(what):
        names = show(row, world)
        if not eyes:
            eyes = {name: Eyes(world, player) for name, player in names.items()}
            minds = {
                name: ReferenceKeeper(figures, hand, Random(0))
                if name[0] == "l"
                else ReferenceTaker(figures)
                for name in names
            }
        if row["episode"] != episode:
            episode = row["episode"]
            for mind in minds.values():
                mind.begin()
        for name in names:
            done = command(row, name)
            if slowed and name[0] == "r" and done[0] == "dash":
                done = done[0], done[1] * slowed, done[2]
            decided = minds[name].decide(eyes[name].view(), int(row["cycle"]))
            eyes[name].did(done)
            job = (
                "keeping"
                if name[0] == "l"
                else "marking"
                if marks(name, names, world)
                else "taking"
            )
            decisions[job] += 1
            same[job] += agree(decided, done, tolerance)
    assert decisions["keeping"] > 3000
    return {job: same[job] / decisions[job] for job in decisions}


def marks(name, names, world) -> bool:
    """Whether two other takers are nearer to the ball."""
    apart = {
        other: math.hypot(player.x - world.ball.x, player.y - world.ball.y)
        for other, player in names.items()
        if other[0] == "r"
    }
    return sum(apart[other] < apart[name] for other in apart) >= 2


def test_players_that_see_everything_decide_as_uts_do():
    found = agreement("full_sight", 0.0, 1.5)
    assert found["keeping"] > 0.98
    assert found["taking"] > 0.995


def test_players_of_a_game_with_takers_that_mark_decide_as_uts_do():
    found = agreement("4v3", 0.0, 1.5, keepers=4, takers=3, width=25.0, height=25.0)
    assert found["keeping"] > 0.98
    assert found["taking"] > 0.99
    assert found["marking"] > 0.98


def test_players_that_see_what_the_simulator_shows_decide_as_uts_do():
    found = agreement("quantised_sight", 4.0, 6.0, sight="quantised")
    assert found["keeping"] > 0.95
    assert found["taking"] > 0.96


@pytest.mark.parametrize("policy", ["hand", "hold", "rand"])
def test_the_same_seed_gives_the_same_episodes(policy):
    def played():
        world = KeepawayWorld(UT, seed=5)
        return play(world, offered(KEEPERS, policy)(world), 3)

    assert played() == played()


def test_an_episode_is_the_same_whatever_was_played_before():
    world = KeepawayWorld(UT, seed=5)
    players = offered(KEEPERS, "hand")(world)
    results = play(world, players, 3)
    again = KeepawayWorld(UT, seed=5)
    assert play(again, offered(KEEPERS, "hand")(again), 1, first=2) == results[2:]


def test_keepers_that_pass_by_plan_outlast_those_that_pass_at_random_or_never():
    def cycles(policy):
        world = KeepawayWorld(UT, seed=1)
        return sum(r.cycles for r in play(world, offered(KEEPERS, policy)(world), 12))

    assert cycles("hand") > 1.5 * cycles("rand") > 1.5 * cycles("hold")


def test_in_one_of_three_cycles_a_player_reckons_where_the_ball_is():
    world = Physics(variant("standard", sight="quantised"), Random(0))
    world.put(world.keepers[0], 0.0, 0.0)
    for other in world.players[1:]:
        world.put(other, 9.0, 9.0)
    eyes = Eyes(world, world.keepers[0])
    believed = []
    for _ in range(3):
        world.put(world.ball, 5.0, 0.0, 0.0, 1.0, 0.0)
        believed.append(eyes.view().ball.x)
    assert believed[:2] == [5.0, 5.0]
    assert believed[2] == pytest.approx(believed[1] + 1.0, abs=0.1)
