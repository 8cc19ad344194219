"""The motion of players and ball is that of rcssserver, as recorded on the real simulator."""

import csv
import gzip
import math
from itertools import groupby, pairwise
from pathlib import Path
from random import Random

import numpy as np
import pytest

from keepaway_world.game.physics import Physics
from keepaway_world.parameters import variant

DATA = Path(__file__).parent / "data"
FIGURES = ("ball_x", "ball_y", "ball_vx", "ball_vy", "x", "y", "vx", "vy", "body")
REPETITIONS = 3  # of each recorded beginning
SIGNIFICANCE = 0.01


def read(name):
    """Return the rows of each scenario, by name."""
    path = DATA / name
    with gzip.open(path, "rt") if name.endswith(".gz") else path.open() as file:
        rows = list(csv.DictReader(file))
    return {key: list(group) for key, group in groupby(rows, key=lambda row: row["scenario"])}


def begin(physics, row):
    """Put player and ball where a recorded row has them; y points down there."""
    value = {figure: float(row[figure]) for figure in FIGURES}
    physics.put(
        physics.ball, value["ball_x"], -value["ball_y"], 0.0, value["ball_vx"], -value["ball_vy"]
    )
    physics.put(
        physics.keepers[0],
        value["x"],
        -value["y"],
        -math.radians(value["body"]),
        value["vx"],
        -value["vy"],
    )
    physics.put(physics.keepers[1], 200.0, 200.0)


def perform(physics, command):
    """Carry out a recorded command, such as ``(kick 60 -120)``, and the cycle."""
    player = physics.keepers[0]
    kind, *values = command.strip("()").split() or [""]
    if kind == "dash":
        physics.dash(player, float(values[0]))
    elif kind == "turn":
        physics.turn(player, -math.radians(float(values[0])))
    elif kind == "kick":
        assert physics.kick(player, float(values[0]), -math.radians(float(values[1])))
    physics.advance()


def seen(physics):
    """Return the figures of a recorded row as they are now."""
    ball, player = physics.ball, physics.keepers[0]
    return (
        ball.x,
        -ball.y,
        ball.vx,
        -ball.vy,
        player.x,
        -player.y,
        player.vx,
        -player.vy,
        -math.degrees(player.heading),
    )


def replay(physics, rows):
    """Yield what happens, row by row, when the recorded commands are given."""
    begin(physics, rows[0])
    yield seen(physics)
    for row in rows[:-1]:
        perform(physics, row["command"])
        yield seen(physics)


NOISE_FREE = read("motion_noise_free.csv")
NOISY = read("motion_default_noise.csv.gz")


def make(seed=0, **figures):
    parameters = variant("standard", keepers=2, takers=0, **figures)
    return Physics(parameters, Random(seed))


def test_without_noise_each_recorded_scenario_is_repeated_exactly():
    for scenario, rows in NOISE_FREE.items():
        physics = make(movement_noise=0.0, kick_noise=0.0, turn_noise=0.0)
        tolerance = 0.05 if scenario == "ball_hits_player" else 0.002
        for row, happened in zip(rows, replay(physics, rows), strict=True):
            recorded = [float(row[figure]) for figure in FIGURES]
            where = scenario, row["cycle"]
            assert happened[:8] == pytest.approx(recorded[:8], abs=tolerance), where
            off = math.remainder(happened[8] - recorded[8], 360.0)
            assert abs(off) < 0.01, where


def samples(noise):
    """Return, for each noisy scenario and cycle, recorded and simulated figures."""
    found = {}
    for name, rows in NOISY.items():
        scenario, repetition = name.split("#")
        for again in range(REPETITIONS):
            physics = make(
                1000 * int(repetition) + again,
                movement_noise=noise,
                kick_noise=noise,
                turn_noise=noise,
            )
            for number, figures in enumerate(replay(physics, rows)):
                recorded, simulated = found.setdefault((scenario, number), ([], []))
                simulated.append(figures)
                if not again:
                    recorded.append([float(rows[number][figure]) for figure in FIGURES])
    return found


def corrected(probabilities):
    """Return the smallest p-value, corrected for how many there are (Bonferroni)."""
    return min(probabilities) * len(probabilities)


def test_where_noise_leads_is_distributed_as_on_the_real_simulator():
    from scipy.stats import ks_2samp

    probabilities = []
    for (_, cycle), (recorded, simulated) in samples(noise=1.0).items():
        if cycle in (1, 2, 5, 10, 20, 40):
            ours, theirs = np.array(simulated), np.array(recorded)
            for column in range(len(FIGURES)):
                if np.std(theirs[:, column]) > 1e-6:
                    p = ks_2samp(ours[:, column], theirs[:, column]).pvalue
                    probabilities.append(p)
    assert len(probabilities) > 300
    assert corrected(probabilities) > SIGNIFICANCE


def deviations(noise):
    """Return how recorded and simulated cycles differ from noise-free ones, by kind of motion.

    Each recorded row is continued for one cycle: by the recorded row after it, by the noisy
    simulation and by one without noise.
    """
    noisy = make(7, movement_noise=noise, kick_noise=noise, turn_noise=noise)
    exact = make(movement_noise=0.0, kick_noise=0.0, turn_noise=0.0)
    found = {}
    for name, rows in NOISY.items():
        if name.startswith("ball_hits_player"):
            continue
        for row, after in pairwise(rows):
            ends = [[float(after[figure]) for figure in FIGURES]]
            for physics in (noisy, exact):
                begin(physics, row)
                perform(physics, row["command"])
                ends.append(seen(physics))
            recorded, simulated, expected = np.array(ends)
            kind = row["command"].strip("()").split(" ")[0]
            columns = {"dash": (6, 7), "turn": (8,), "kick": (2, 3), "": (2, 3)}[kind]
            for column in columns:
                if kind in ("", "dash") and math.hypot(*expected[list(columns)]) < 0.05:
                    continue
                motion = f"{kind or 'roll'} {FIGURES[column]}"
                theirs, ours = found.setdefault(motion, ([], []))
                theirs.append((recorded - expected)[column])
                ours.append((simulated - expected)[column])
    return found


def least_probable(noise):
    from scipy.stats import ks_2samp

    found = deviations(noise)
    assert len(found["roll ball_vx"][0]) > 5000
    return corrected([ks_2samp(theirs, ours).pvalue for theirs, ours in found.values()])


def test_the_noise_of_each_cycle_is_distributed_as_on_the_real_simulator():
    assert least_probable(noise=1.0) > SIGNIFICANCE


@pytest.mark.parametrize("factor", [0.85, 1.15])
def test_noise_that_is_a_little_larger_or_smaller_would_be_noticed(factor):
    assert least_probable(noise=factor) < SIGNIFICANCE
