"""Behaviors trained from runs without commands, beside the same runs' commands given by hand.

Two drivers are copied: a program that goes to the ball, with noise as if a person drove, and the
shipped Keepaway, by one flat automaton of basic behaviors. research/shown_runs.md has the figures.

    scripts/python research/shown_runs.py
    scripts/python research/shown_runs.py --task keepaway --seeds 2
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import sqrt
from pathlib import Path
from random import Random
from statistics import fmean, stdev
from typing import Annotated, Any

import numpy as np
import typer

from hitab_core import BehaviorLibrary, Repertoire, Term
from hitab_core.labeling import ShownAction, Strip
from hitab_core.texts.errors import TrainingError
from hitab_world.inprocess import AutomatonPlayer, Player, PolicyPlayer, cycle, perform, play
from keepaway_world.domain import DOMAIN
from keepaway_world.hand_written import servo
from keepaway_world.parameters import PAPER
from keepaway_world.percept import BALL
from keepaway_world.world import KeepawayWorld

FIRST_SEED = 52_000  # tried with 0 to 9
ONE = "keeper_1"
LIBRARY = BehaviorLibrary(
    Path(__file__).parents[1] / "ros2_ws/src/keepaway_world/libraries/keepaway", DOMAIN
)
SERVO = ("GoFast", "GoMedium", "GoSlow", "TurnToBall", "Stop")
NEAR = ("DistanceTo(ball)", "DirectionTo(ball)", "BallIsKickable")
LONGEST = 60
"""Cycles that a keeper may take to the ball."""

Told = Callable[[Any, Player], str]


@dataclass
class Shown:
    """What a driver did, and which behavior each moment was, which no label is learned from."""

    moments: list[ShownAction]
    truth: list[str]


def world_of(seed: int) -> KeepawayWorld:
    """Return a world with slow takers."""
    return KeepawayWorld(replace(PAPER, taker_speed=0.25), seed)


def record(players: dict[str, Player], was: Callable[[], str], seed: int, episodes: int) -> Shown:
    """Return what a keeper did in some episodes of at most 10 s.

    Args:
        players: by name.
        was: returns which behavior it has just been.
        seed: of the world.
        episodes: how many.
    """
    world, shown = world_of(seed), Shown([], [])
    for episode in range(episodes):
        world.reset(episode)
        for player in players.values():
            player.begin(seed, episode)
        while not world.ended and world.episode_cycle < 100:
            n = len(shown.moments)
            cycle(world, players)
            body: Any = players[ONE].body
            values, heard, did = list(body.values), list(body.heard), tuple(body.act()[0])
            shown.moments.append(ShownAction(n / 10, n / 10, n, episode, values, heard, did))
            shown.truth.append(was())
    return shown


def driver(noise: float, seed: int) -> tuple[Player, list[str]]:
    """Return a program that goes to the ball, and the list of what it has been.

    Args:
        noise: of what it does: dashes by so many hundreds of power, turns by so many rad.
        seed: of the noise.
    """
    random, was = Random(seed), [""]

    def drive(body: Any) -> None:
        distance, direction = body.values[BALL : BALL + 2]
        was[0] = servo(distance, direction, float(body.ball_is_kickable))
        DOMAIN.behaviors[was[0]].pulse(body)
        action = body.act()[0]
        if noise and action and action[0] == 1.0:
            body.dash(action[1] + random.gauss(0, 100 * noise))
        elif noise and action and action[0] == 2.0:
            body.turn_by(action[1] + random.gauss(0, noise))

    return PolicyPlayer(DOMAIN.body(ONE), drive), was


def trained(strip: Strip, folder: Path) -> Repertoire:
    """Return the behaviors with a trained one, Copied."""
    library = BehaviorLibrary(folder, DOMAIN)
    strip.train("Copied", library, "runs")
    return Repertoire(DOMAIN, library.load())


def both(
    shown: Shown, behaviors: Sequence[str], features: Sequence[str]
) -> tuple[Repertoire, Repertoire, float]:
    """Return what is trained without commands and with them, and the share of right labels, %."""
    with tempfile.TemporaryDirectory() as folder:
        strip = Strip(shown.moments, DOMAIN, ONE, behaviors, features)
        found = [strip.behaviors[i] for i in strip.labels.tolist()]
        copied = trained(strip, Path(folder, "found"))
        strip.labels = np.array([strip.behaviors.index(name) for name in shown.truth])
        told = trained(strip, Path(folder, "told"))
    return copied, told, 100 * fmean(a == b for a, b in zip(found, shown.truth, strict=True))


def seconds_to_ball(player: Player, seed: int, episodes: int) -> list[float]:
    """Return how long a keeper takes to the ball in each episode, s; at most 6."""
    world, found = world_of(seed), []
    for episode in range(episodes):
        world.reset(episode)
        player.begin(seed, episode)
        taken = LONGEST
        while not world.ended and world.episode_cycle < taken:
            cycle(world, {ONE: player})
            if player.body.ball_is_kickable:
                taken = world.episode_cycle
        found.append(taken / 10)
    return found


def guess(seed: int) -> Player:
    """Return who does one of the behaviors at random for half a second each: zero examples."""
    random, now = Random(seed), [""]

    def drive(body: Any) -> None:
        if not now[0] or random.random() < 0.2:
            now[0] = random.choice(SERVO)
        DOMAIN.behaviors[now[0]].pulse(body)

    return PolicyPlayer(DOMAIN.body(ONE), drive)


def to_the_ball(seed: int, noise: float, shown: int, episodes: int) -> dict[str, float]:
    """Return the seconds to the ball of the driver, its copies and a guess, and the labels."""
    player, was = driver(noise, seed)
    runs = record({ONE: player}, lambda: was[0], seed, shown)
    try:
        copied, told, right = both(runs, SERVO, NEAR)
    except TrainingError as refused:
        typer.echo(f"seed {seed}: {refused}")
        return {}
    test = seed + 5_000
    term = Term("Copied")
    return {
        "labels right, %": right,
        "changes": sum(a != b for a, b in pairwise(runs.truth)),
        "driver without noise": fmean(seconds_to_ball(driver(0, 0)[0], test, episodes)),
        "without commands": fmean(
            seconds_to_ball(AutomatonPlayer(copied, term, ONE), test, episodes)
        ),
        "with commands": fmean(seconds_to_ball(AutomatonPlayer(told, term, ONE), test, episodes)),
        "zero examples": fmean(seconds_to_ball(guess(seed), test, episodes)),
    }


def keepaway(seed: int, shown: int, episodes: int) -> dict[str, float]:
    """Return how long teams hold the ball, s: the shipped one, its copies, and no examples."""
    shipped = Repertoire(DOMAIN, LIBRARY.load())
    players = perform(world_of(seed), shipped, "Keepaway")
    was: Any = players[ONE]
    before = [""]

    def active() -> str:
        name = was.running.active_path[-1]
        before[0] = name if name in DOMAIN.behaviors else before[0]  # a flag: it was the last one
        return before[0]

    runs = record(players, active, seed, shown)
    features = sorted({str(f) for a in LIBRARY.load().values() for f in a.features} - {"Done"})
    behaviors = [name for name, b in DOMAIN.behaviors.items() if not b.parameters]
    copied, told, right = both(runs, behaviors, features)
    test = seed + 5_000

    def held(repertoire: Repertoire, behavior: str) -> float:
        world = world_of(test)
        results = play(world, perform(world, repertoire, behavior), episodes, cycles_max=1000)
        return fmean(result.cycles / 10 for result in results)

    return {
        "labels right, %": right,
        "changes": sum(a != b for a, b in pairwise(runs.truth)),
        "shipped": held(shipped, "Keepaway"),
        "without commands": held(copied, "Copied"),
        "with commands": held(told, "Copied"),
        "zero examples: GetOpen": held(shipped, "GetOpen"),
    }


def main(
    task: Annotated[str, typer.Option(help="ball or keepaway; default: both.")] = "",
    seeds: int = 10,
    first: int = FIRST_SEED,
    episodes: int = 50,
) -> None:
    """Print the figures: mean and standard error of the seeds."""
    cells: list[tuple[str, Callable[[int], dict[str, float]]]] = []
    for noise in (0.0, 0.05, 0.1, 0.2) if task in ("", "ball") else ():
        for shown in (3, 10):

            def one(seed: int, noise: float = noise, shown: int = shown) -> dict[str, float]:
                return to_the_ball(seed, noise, shown, episodes)

            cells.append((f"to the ball, noise {noise:g}, {shown} runs shown", one))
    for shown in (5, 20) if task in ("", "keepaway") else ():

        def other(seed: int, shown: int = shown) -> dict[str, float]:
            return keepaway(seed, shown, episodes)

        cells.append((f"keepaway, {shown} runs shown", other))
    for name, measured in cells:
        found = [row for seed in range(first, first + seeds) if (row := measured(seed))]
        typer.echo(f"{name}: {len(found)} seeds")
        for what in found[0] if found else ():
            values = [row[what] for row in found]
            error = stdev(values) / sqrt(len(values)) if len(values) > 1 else 0.0
            typer.echo(f"  {what:24} {fmean(values):7.2f} ± {error:.2f}")
        if found:
            difference = [row["without commands"] - row["with commands"] for row in found]
            error = stdev(difference) / sqrt(len(found)) if len(found) > 1 else 0.0
            typer.echo(f"  {'difference, paired':24} {fmean(difference):7.2f} ± {error:.2f}")


if __name__ == "__main__":
    typer.run(main)
