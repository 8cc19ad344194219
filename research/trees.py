"""Compares the transition tree with scikit-learn's on data sets that HiTAB was not made for.

Each learns the same folds: ten times ten of them, stratified. Beside our tree are ones that choose
splits otherwise, which shows what the criterion costs.

    scripts/python research/trees.py
    scripts/python research/trees.py --data iris --data wine --repeats 2

No number of the engine is fitted to these data.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from math import sqrt
from random import Random
from statistics import fmean, stdev
from typing import Annotated, Any

import numpy as np
import typer
from report import prefixed, progress
from rich.console import Console
from rich.table import Table
from sklearn.datasets import load_breast_cancer, load_digits, load_iris, load_wine
from sklearn.model_selection import RepeatedStratifiedKFold
from sklearn.tree import DecisionTreeClassifier

from hitab_core.domain import Scale
from hitab_core.learning.gain_ratio import TIE
from hitab_core.learning.splits import Chosen, Leaves, Split, worthy_splits
from hitab_core.learning.transition_tree import TransitionTree

DATA = {
    "iris": load_iris,
    "wine": load_wine,
    "cancer": load_breast_cancer,
    "digits": load_digits,
}
FOLDS = 10
REFERENCE = "scikit-learn"

Learn = Callable[[Any, Any, int], Callable[[Any], Any]]
"""``learn(X, y, seed)`` returns what predicts classes."""


class Largest:
    """Chooses the split with the largest gain or gain ratio; on a tie, the first or any.

    Args:
        ratio: whether the gain ratio is compared, of splits with at least average gain.
        random: draws among ties.
    """

    def __init__(self, *, ratio: bool, random: Random | None = None) -> None:
        self._ratio, self._random = ratio, random

    def __call__(
        self, candidates: Sequence[Split | None], scales: Sequence[Scale], leaves: Leaves | None
    ) -> Chosen | None:
        """Choose; see `hitab_core.learning.splits.Choose`."""
        worthy = worthy_splits(candidates)
        if not worthy:
            return None
        worth = [split.ratio if self._ratio else split.gain for _, split in worthy]
        best = [one for one, value in zip(worthy, worth, strict=True) if value >= max(worth) - TIE]
        return self._random.choice(best) if self._random else best[0]


def _ours(choose: Callable[[int], Any] | None = None, **settings: Any) -> Learn:
    def learn(X: Any, y: Any, seed: int) -> Callable[[Any], Any]:
        chosen = None if choose is None else choose(seed)
        return TransitionTree(**settings).fit(X, y, choose=chosen).predict

    return learn


def _theirs(X: Any, y: Any, seed: int) -> Callable[[Any], Any]:
    predict: Callable[[Any], Any] = (
        DecisionTreeClassifier(criterion="entropy", random_state=seed).fit(X, y).predict
    )
    return predict


LEARNERS: dict[str, Learn] = {
    REFERENCE: _theirs,
    "ours": _ours(),
    "gain ratio, random ties": _ours(lambda seed: Largest(ratio=True, random=Random(seed))),
    "gain, first of ties": _ours(lambda _: Largest(ratio=False)),
    "gain, random ties": _ours(lambda seed: Largest(ratio=False, random=Random(seed))),
}


def accuracies(
    X: Any, y: Any, learners: Sequence[str], repeats: int, seed: int, say: Callable[[str], None]
) -> dict[str, list[float]]:
    """Return each learner's fraction of right answers in each fold."""
    folds = RepeatedStratifiedKFold(n_splits=FOLDS, n_repeats=repeats, random_state=seed)
    found: dict[str, list[float]] = {name: [] for name in learners}
    for number, (learned, asked) in enumerate(folds.split(X, y)):
        for name in learners:
            say(f"fold {number + 1} of {FOLDS * repeats}, {name}")
            predict = LEARNERS[name](X[learned], y[learned], seed + number)
            found[name].append(float(np.mean(predict(X[asked]) == y[asked])))
    return found


def difference(one: Sequence[float], other: Sequence[float]) -> tuple[float, float, float]:
    """Return a mean difference of folds, its naive standard error, and the corrected one.

    The naive one takes folds for independent. They share most of what is learned from, for which
    the other corrects: C. Nadeau, Y. Bengio, Inference for the Generalization Error, Machine
    Learning 52, 2003.
    """
    paired = [a - b for a, b in zip(one, other, strict=True)]
    spread, n = stdev(paired), len(paired)
    return fmean(paired), spread * sqrt(1 / n), spread * sqrt(1 / n + 1 / (FOLDS - 1))


def main(
    data: Annotated[list[str] | None, typer.Option(help="Data set; repeat for several.")] = None,
    learners: Annotated[
        list[str] | None, typer.Option("--learner", help="Learner; repeat for several.")
    ] = None,
    repeats: Annotated[int, typer.Option(help="How often the data are cut in ten.", min=1)] = 10,
    seed: Annotated[int, typer.Option(help="Of the folds and of ties.")] = 2003,
) -> None:
    """Compare the transition tree with scikit-learn's."""
    names = [REFERENCE, *(learners or [name for name in LEARNERS if name != REFERENCE])]
    table = Table("data", "learner", "accuracy", "minus scikit-learn's", "se naive", "corrected")
    for name in data or DATA:
        X, y = DATA[name](return_X_y=True)
        found = accuracies(X, y, names, repeats, seed, prefixed(progress, f"{name}: "))
        progress("")
        for learner in names:
            mean, naive, corrected = difference(found[learner], found[REFERENCE])
            cells = (f"{mean:+.4f}", f"{naive:.4f}", f"{corrected:.4f}")
            if learner == REFERENCE:
                cells = ("", "", "")
            table.add_row(name, learner, f"{fmean(found[learner]):.4f}", *cells)
            print(name, learner, f"{fmean(found[learner]):.4f}", *cells, file=sys.stderr)
    Console().print(table)


if __name__ == "__main__":
    typer.run(main)
