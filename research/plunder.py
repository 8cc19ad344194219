"""Labels PLUNDER's demonstrations, whose labels are hidden, and scores what is learned as they do.

Their repository has no license file, so none of it is here: it is cloned for you, or read from a
clone. research/plunder.md has the method and the figures.

    scripts/python research/plunder.py
    scripts/python research/plunder.py --data ~/plunder --seeds 3 --task stack
"""

from __future__ import annotations

import json as js
import subprocess
from collections.abc import Callable, Mapping, Sequence
from math import sqrt
from pathlib import Path
from statistics import fmean, stdev
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer

from hitab_core import Scale
from hitab_core.labeling import Run, Shown, apart, examples_of, forward, label, steps_of
from hitab_core.learning import learn_transitions
from hitab_core.numeric.arrays import Floats, Integers

SOURCE = "https://github.com/ut-amrl/plunder"
CACHE = Path("~/.cache/hitab/plunder").expanduser()
FIRST_SEED = 41_000  # tried with 0 to 2

Columns = Mapping[str, Floats]


class Task(NamedTuple):
    """One of their tasks: its files, what each behavior does, and what is decided by."""

    folder: str
    files: int
    behaviors: tuple[str, ...]
    does: Callable[[Columns, Columns], list[list[Any]]]
    done: tuple[str, ...]
    features: Callable[[Columns], Mapping[str, Any]]
    theirs: float


def target(now: Columns, last: Columns) -> list[list[Any]]:
    """Return the acceleration of each behavior: one step of 1 m/s² towards what it wants."""
    acc = last["acc"]
    steady = np.where(acc < 0, np.minimum(acc + 1, 0), np.maximum(acc - 1, 0))
    return [
        [np.minimum(acc + 1, now["accMax"])],
        [steady],
        [np.maximum(acc - 1, now["decMax"])],
    ]


def road(turn: float, top: float, turning: Callable[[Floats], Any]) -> Callable[..., Any]:
    """Return what the behaviors of a car do: steering and acceleration.

    Args:
        turn: the most that the steering changes in a step, rad.
        top: the speed that FASTER wants, m/s.
        turning: from the speed, the acceleration wanted while changing lanes.
    """

    def does(now: Columns, last: Columns) -> list[list[Any]]:
        lane = np.arctan((np.round(now["y"] / 4) * 4 - now["y"]) / 30)
        aside = turning(now["vx"])
        wanted: list[tuple[Any, Any]] = [
            (lane, top - now["vx"]),
            (lane, now["f_vx"] - now["vx"]),
            (-0.15, aside),
            (0.15, aside),
        ]
        steer, acc = last["steer"], last["acc"]
        return [
            [
                np.clip(heading - now["heading"], steer - turn, steer + turn),
                np.clip(pace, acc - 6, acc + 4),
            ]
            for heading, pace in wanted
        ]

    return does


def arm(now: Columns, last: Columns) -> list[list[Any]]:
    """Return the velocity of the hand and of its fingers in each behavior."""

    def to(which: str, end: float, *, above: float = 0.0, slow: bool = True) -> list[Any]:
        x, y, z = (4 * now[which.replace("_", axis)] for axis in "xyz")
        z = z + 4 * above
        if slow:
            z = np.where(z < 0, np.maximum(last["vz"] - 0.15, z), z)
        return [x, y, z, end]

    return [
        to("b_1", 1, slow=False),
        to("t_2", -1, above=0.01),
        [0, 0, 0.5, 1],
        to("b_2", 1),
        [0, 0, 0.5, -1],
    ]


def gaps(now: Columns, *sides: str) -> dict[str, Any]:
    """Return how many seconds ahead the car of a lane is."""
    return {f"{side} s": (now[f"{side}_x"] - now["x"]) / now["vx"] for side in sides}


TASKS = {
    "1D target": Task(
        "1D-target/snapshots/example_snapshot/sim",
        30,
        ("ACC", "CON", "DEC"),
        target,
        ("acc",),
        lambda now: {
            "too fast": now["vel"] - now["vMax"],
            "room to stop": now["dns"] + now["vel"] ** 2 / (2 * now["decMax"]),
        },
        98.2,
    ),
    "highway": Task(
        "2D-highway-env/python-gen",
        30,
        ("FASTER", "SLOWER", "LANE_LEFT", "LANE_RIGHT"),
        road(0.04, 40, lambda vx: 30 - vx),
        ("steer", "acc"),
        lambda now: gaps(now, "l", "f", "r") | {"left farther": now["l_x"] - now["r_x"]},
        94.1,
    ),
    "merge": Task(
        "2D-merge/snapshots/example_snapshot/python-gen",
        30,
        ("FASTER", "SLOWER", "LANE_LEFT", "LANE_RIGHT"),
        road(0.06, 40, lambda vx: -0.5),
        ("steer", "acc"),
        lambda now: gaps(now, "f", "r"),
        99.2,
    ),
    "stack": Task(
        "panda-stack/python-gen",
        20,
        ("MOVE_TO_CUBE_BOTTOM", "MOVE_TO_TARGET", "LIFT", "MOVE_TO_CUBE_TOP", "GRASP"),
        arm,
        ("vx", "vy", "vz", "end"),
        lambda now: {
            "z": now["z"],
            "bottom z": now["bz1"],
            "top z": now["bz2"],
            "target aside": np.abs(now["tx2"]) + np.abs(now["ty2"]),
        },
        94.0,
    ),
}
RARE = 0.2
"""What is less probable in a leaf may be wrong labels; chosen by the runs shown, seeds 0 and 1."""

TRAINED = 10  # the first files; all others are the test


class Given(NamedTuple):
    """One demonstration, and the labels that nothing learns from."""

    run: Run
    truth: Integers


def read(task: Task, file: Path) -> Given:
    """Return a demonstration of a task."""
    with file.open() as lines:
        names = [name.strip().removeprefix("LA.") for name in next(lines).split(",")]
        table = np.loadtxt(lines, delimiter=",", ndmin=2).T
    now = dict(zip(names, table, strict=True))
    last = {name: np.concatenate([[0.0], now[name][:-1]]) for name in task.done}
    n = table.shape[1]
    would = [[np.broadcast_to(x, n) for x in outputs] for outputs in task.does(now, last)]
    did = np.stack([now[name] for name in task.done], axis=1)
    features = np.stack(list(task.features(now).values()), axis=1)
    run = Run(features, apart(did, np.moveaxis(np.array(would), 2, 0)))
    return Given(run, now["HA"].astype(np.int64))


Functions = Mapping[str, Any]


def learned(shown: Shown, task: Task, runs: list[Run], *, drawn: bool = False) -> Functions:
    """Return the transition functions that the labels of runs teach, or those drawn of them."""
    sequences = shown.drawn if drawn else [one[None] for one in shown.labels]
    scales = [Scale()] * runs[0].features.shape[1]
    return learn_transitions(
        list(examples_of(runs, sequences, task.behaviors)), scales, "tree(prune=True)"
    )


def policy_accuracy(
    functions: Functions,
    task: Task,
    given: list[Given],
    *,
    sure: bool = False,
    least: float = 0.0,
) -> float:
    """Return the share of moments, in %, where the policy alone is in the right state.

    The exact mean over what it may draw, where they draw 100 times. It sees each moment as it was
    recorded, never what was done. As theirs, it leaves out a run's first moment.

    Args:
        functions: what was learned.
        task: of the runs.
        given: the runs.
        sure: whether it takes the most probable state rather than drawing one.
        least: never draw what is less probable.
    """
    right = total = 0.0
    for run, truth in given:
        start, steps = steps_of(functions, task.behaviors, run.features)
        if sure:
            start, steps = (np.eye(len(start))[p.argmax(axis=-1)] for p in (start, steps))
        start, steps = (np.where(p < least, 0.0, p) for p in (start, steps))
        start, steps = (p / p.sum(axis=-1, keepdims=True) for p in (start, steps))
        belief = forward(start, steps, np.ones(steps.shape[:2]))
        right += belief[np.arange(1, len(truth)), truth[1:]].sum()
        total += len(truth) - 1
    return 100 * right / total


def label_accuracy(labels: Sequence[Integers], given: list[Given]) -> float:
    """Return the share of the moments shown, in %, whose label is right."""
    hits = [one[1:] == g.truth[1:] for one, g in zip(labels, given, strict=True)]
    return 100 * float(np.concatenate(hits).mean())


def measured(task: Task, data: Path, seed: int) -> dict[str, float]:
    """Return the accuracies of one seed."""
    given = [read(task, data / task.folder / f"data{i}.csv") for i in range(task.files)]
    train, test = given[:TRAINED], given[TRAINED:]
    scales = [Scale()] * train[0].run.features.shape[1]
    runs = [g.run for g in train]
    shown = label(runs, task.behaviors, scales, seed=seed)
    prior = label(runs, task.behaviors, scales, rounds=0, seed=seed)
    told = [Run(g.run.features, g.run.apart, dict(enumerate(g.truth.tolist()))) for g in train]
    given_labels = learned(label(told, task.behaviors, scales, rounds=0, seed=seed), task, told)
    ours, sticky = learned(shown, task, runs), learned(prior, task, runs)
    drawn = learned(shown, task, runs, drawn=True)
    nearest = [np.abs(g.run.apart / shown.spread).sum(axis=2).argmin(axis=1) for g in train]
    return {
        "policy, runs shown": policy_accuracy(ours, task, train),
        "policy, unseen": policy_accuracy(ours, task, test),
        "policy, unseen, sure": policy_accuracy(ours, task, test, sure=True),
        "policy, runs shown, no rare": policy_accuracy(ours, task, train, least=RARE),
        "policy, unseen, no rare": policy_accuracy(ours, task, test, least=RARE),
        "drawn, runs shown, no rare": policy_accuracy(drawn, task, train, least=RARE),
        "drawn, unseen, no rare": policy_accuracy(drawn, task, test, least=RARE),
        "sticky, runs shown": policy_accuracy(sticky, task, train),
        "sticky, unseen": policy_accuracy(sticky, task, test),
        "true labels, unseen": policy_accuracy(given_labels, task, test),
        "labels": label_accuracy(shown.labels, train),
        "labels, sticky": label_accuracy(prior.labels, train),
        "labels, likelihood alone": label_accuracy(nearest, train),
        "rounds": shown.rounds,
    }


def main(
    data: Annotated[Path, typer.Option(help="A clone; cloned if it is not there.")] = CACHE,
    seeds: int = 10,
    first: int = FIRST_SEED,
    task: Annotated[str, typer.Option(help="Only this task.")] = "",
    json: Path | None = None,
) -> None:
    """Print the accuracies of each task beside theirs."""
    if not data.exists():
        typer.echo(f"cloning {SOURCE}, which has no license file, to {data} for your own use")
        subprocess.run(["git", "clone", "--depth", "1", SOURCE, str(data)], check=True)
    found: dict[str, Any] = {}
    for name, one in TASKS.items():
        if task in ("", name):
            runs = [measured(one, data, first + i) for i in range(seeds)]
            found[name] = runs
            typer.echo(f"{name}: theirs {one.theirs}")
            for row in runs[0]:
                values = [run[row] for run in runs]
                error = stdev(values) / sqrt(len(values)) if len(values) > 1 else 0.0
                typer.echo(f"  {row:29} {fmean(values):6.2f} ± {error:.2f}")
    if json is not None:
        json.write_text(js.dumps(found, indent=1))


if __name__ == "__main__":
    typer.run(main)
