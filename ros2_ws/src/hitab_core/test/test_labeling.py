"""Runs that are shown without commands, made by an automaton that is known."""

from __future__ import annotations

import numpy as np
import pytest

from hitab_core import FeatureKind, Scale
from hitab_core.labeling import Run, apart, examples_of, forward, label, steps_of
from hitab_core.labeling.labels import ROUNDS
from hitab_core.learning import learn_transitions
from hitab_core.texts.errors import TrainingError

BEHAVIORS = ("Left", "Right")
SPREAD = 0.6


def run(seed: int, n: int = 200) -> tuple[Run, np.ndarray]:
    """Return a cart that turns at 0 and at 10, driven with noise, and what each moment was."""
    rng = np.random.default_rng(seed)
    truth, seen, at, state = [], [], 5.0, 1
    for _ in range(n):
        state = 0 if at > 10 else 1 if at < 0 else state
        truth.append(state)
        seen.append([at])
        at += 0.4 * (2 * state - 1) + rng.normal(0, 0.05)
    did = 2.0 * np.array(truth)[:, None] - 1 + rng.normal(0, SPREAD, (n, 1))
    would = np.broadcast_to([[-1.0], [1.0]], (n, 2, 1))
    return Run(np.array(seen), apart(did, would)), np.array(truth)


def test_labels_and_automaton_are_found_without_a_command():
    made = [run(seed) for seed in range(5)]
    shown = label([r for r, _ in made], BEHAVIORS, [Scale()])
    right = np.concatenate([a == t for a, (_, t) in zip(shown.labels, made, strict=True)])
    nearest = [np.abs(r.apart[..., 0]).argmin(axis=1) == t for r, t in made]
    assert right.mean() > 0.99 > np.concatenate(nearest).mean()
    assert shown.rounds < ROUNDS, "the labels no longer change"
    assert shown.spread[0] == pytest.approx(SPREAD, rel=0.1)
    unseen, truth = run(99)
    alone = [one[None] for one in shown.labels]
    taught = list(examples_of([r for r, _ in made], alone, BEHAVIORS))
    functions = learn_transitions(taught, [Scale()], "tree(prune=True)")
    start, steps = steps_of(functions, BEHAVIORS, unseen.features)
    belief = forward(start, steps, np.ones((len(truth), 2)))
    assert (belief.argmax(axis=1) == truth).mean() > 0.95


def test_a_moment_that_no_behavior_explains_is_named():
    shown_run, _ = run(7)
    shown_run.apart[50] = 30.0
    shown = label([shown_run], BEHAVIORS, [Scale()])
    assert np.flatnonzero(shown.unexplained[0]).tolist() == [50]


def test_what_a_person_says_counts():
    made, truth = run(7)
    said = Run(made.features, made.apart, {20: 1 - int(truth[20])})
    assert label([said], BEHAVIORS, [Scale()]).labels[0][20] == 1 - truth[20]


def test_three_moments_are_enough_to_label():
    shown = label([run(3, 3)[0]], BEHAVIORS, [Scale()])
    assert len(shown.labels[0]) == 3


def test_nothing_shown_is_refused():
    with pytest.raises(TrainingError, match="nothing was shown"):
        label([], BEHAVIORS, [Scale()])


def test_directions_wrap_around():
    circle = Scale(FeatureKind.TOROIDAL, 360.0)
    assert apart([[179.0]], [[[-179.0]]], [circle])[0, 0, 0] == pytest.approx(-2.0)
