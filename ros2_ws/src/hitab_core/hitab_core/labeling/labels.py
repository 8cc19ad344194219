"""Labels of moments, found in alternation with learning the automaton that chose them.

With given transition functions, those sequences of states are likely that explain both the
actions and the times of changes; with given sequences, the engine's own learner learns the
functions. The two alternate until the labels settle, as in expectation maximization. The states
are behaviors.

Reference: J. Xin et al., Programmatic Imitation Learning from Unlabeled and Noisy Demonstrations,
2024, arXiv 2303.01440, with a program where this has trees.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from hitab_core.automaton import START
from hitab_core.domain import Scale
from hitab_core.example import Example
from hitab_core.labeling.likelihood import log_likelihoods, spread_of, unexplained
from hitab_core.labeling.paths import draw, forward, posterior
from hitab_core.learning import learn_transitions
from hitab_core.numeric.arrays import Booleans, Floats, Integers
from hitab_core.texts.errors import TrainingError
from hitab_core.transition_function import LearnedTransition

STAY = 0.9
"""Probability of staying, before anything was learned."""

SLIP = 0.02
"""Probability of a change that the automaton does not expect: people are no automata."""

DRAWS, MOMENTS = 10, 20_000
"""Number of sequences drawn of each run, and maximum number of their moments in all."""

BETWEEN = "tree(prune=True, min_samples_leaf=40)"
"""Learns from the drawn sequences; with smaller leaves, it would confirm whatever was drawn."""

ROUNDS = 12

SETTLED = 0.002
"""The share of moments whose label may still change when the labels have settled."""

Functions = Mapping[str, LearnedTransition]
Progress = Callable[[int, int, str], None]
"""Called with the amount done, the total and the current activity."""


def no_progress(done: int, total: int, doing: str) -> None:
    """Ignore the progress."""


@dataclass(frozen=True)
class Run:
    """One run that was shown.

    Attributes:
        features: shape (n, m), seen at each moment.
        apart: shape (n, k, d), distance of the action from each behavior's output.
        known: by moment, the index of the behavior that a person chose.
    """

    features: Floats
    apart: Floats
    known: Mapping[int, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Shown:
    """Labeled runs.

    Attributes:
        labels: by run, the index of the most probable behavior at each moment.
        confidence: by run, the probability of that behavior at each moment.
        unexplained: by run and moment, whether no behavior explains the action.
        drawn: by run, sequences of labels drawn by their probability, shape (draws, n).
        spread: shape (d,), spread of the actions around the outputs of the behaviors.
        rounds: number of alternations; 0 for a sticky prior alone.
    """

    labels: tuple[Integers, ...]
    confidence: tuple[Floats, ...]
    unexplained: tuple[Booleans, ...]
    drawn: tuple[Integers, ...]
    spread: Floats
    rounds: int


def label(
    runs: Sequence[Run],
    behaviors: Sequence[str],
    scales: Sequence[Scale],
    *,
    rounds: int = ROUNDS,
    seed: int = 0,
    progress: Progress = no_progress,
) -> Shown:
    """Return the behavior of each moment of some runs.

    Args:
        runs: runs of one person or script.
        behaviors: names of the k behaviors.
        scales: scales of the m features.
        rounds: maximum number of alternations; 0 for a sticky prior alone.
        seed: seed of the draws.
        progress: called with the number of rounds done.

    Raises:
        TrainingError: if there is nothing to label.
    """
    if not runs or min(len(run.features) for run in runs) == 0 or not behaviors:
        raise TrainingError("nothing was shown: give at least one moment and one behavior")
    rng = np.random.default_rng(seed)
    draws = max(1, min(DRAWS, MOMENTS // sum(len(run.features) for run in runs)))
    every = np.concatenate([run.apart for run in runs])
    spread = spread_of(every)
    functions: Functions = {}
    before: Integers | None = None
    for done in range(rounds + 1):
        drawn, beliefs = [], []
        for run in runs:
            start, steps = _prior(functions, behaviors, run.features)
            ahead = forward(start, steps, _odds(run, spread))
            beliefs.append(posterior(ahead, steps))
            drawn.append(draw(ahead, steps, draws, rng))
        labels = [belief.argmax(axis=1) for belief in beliefs]
        now = np.concatenate(labels)
        spread = spread_of(every, now)
        settled = before is not None and float((now != before).mean()) <= SETTLED
        if settled or done == rounds:
            break
        before = now
        functions = learn_transitions(list(examples_of(runs, drawn, behaviors)), scales, BETWEEN)
        progress(done + 1, rounds, "alternating")
    return Shown(
        tuple(labels),
        tuple(belief.max(axis=1) for belief in beliefs),
        tuple(unexplained(run.apart, spread) for run in runs),
        tuple(drawn),
        spread,
        done,
    )


def steps_of(
    functions: Functions, behaviors: Sequence[str], features: Floats
) -> tuple[Floats, Floats]:
    """Return where an automaton starts and how probable each step is, for `forward`.

    A behavior without a transition function stays. The start is as if the first step stayed.

    Returns:
        shape (k,) and shape (n, k, k).
    """
    k = len(behaviors)
    place = {behavior: i for i, behavior in enumerate(behaviors)}
    found = np.tile(np.eye(k), (len(features), 1, 1))
    for state, function in functions.items():
        columns = [place[next_state] for next_state in function.labels]  # type: ignore[attr-defined]
        if state == START:
            start = np.zeros(k)
            start[columns] = function.predict_proba(features[:1])[0]  # type: ignore[attr-defined]
            continue
        found[:, place[state]] = 0.0
        found[:, place[state], columns] = function.predict_proba(features)  # type: ignore[attr-defined]
    found[0] = np.eye(k)
    return start, found


def _prior(
    functions: Functions, behaviors: Sequence[str], features: Floats
) -> tuple[Floats, Floats]:
    k = len(behaviors)
    if not functions:
        one = np.full((k, k), (1 - STAY) / k) + STAY * np.eye(k)
        return np.full(k, 1 / k), np.broadcast_to(one, (len(features), k, k))
    start, steps = steps_of(functions, behaviors, features)
    return (1 - SLIP) * start + SLIP / k, (1 - SLIP) * steps + SLIP / k


def _odds(run: Run, spread: Floats) -> Floats:
    found = log_likelihoods(run.apart, spread)
    odds = np.exp(found - found.max(axis=1, keepdims=True))
    for moment, which in run.known.items():
        odds[moment] = np.where(np.arange(odds.shape[1]) == which, 1.0, 0.0)
    return np.asarray(odds)


def examples_of(
    runs: Sequence[Run], drawn: Sequence[Integers], behaviors: Sequence[str]
) -> Iterator[Example]:
    """Yield an example for each moment of each sequence: the change from the moment before."""
    for run, sequences in zip(runs, drawn, strict=True):
        rows = [tuple(row) for row in run.features.tolist()]
        for sequence in sequences.tolist():
            states = [START, *(behaviors[i] for i in sequence)]
            for row, (state, next_state) in zip(rows, pairwise(states), strict=True):
                yield Example(state, row, next_state)
