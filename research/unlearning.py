"""Measures how well mistaken examples are found, on data sets with injected label noise.

The protocol follows K. Sullivan and others, Unlearning from Demonstration (IJCAI 2013): a part of
a data set is the examples, sparse or plenty, with some labels replaced by others at random; of a
second, clean part those that the tree misclassifies are its corrections; the rest tests it. All
methods get the corrections as further, trusted examples, may discard examples, and then learn the
same unpruned tree. (The paper's own data sets and splits are not known in detail, so its figures
do not compare.)

- as taught: discards nothing.
- ours: discards what `hitab_core.advice.unlearning.propose` calls a mistake.
- C4.5 pruning: discards nothing, and prunes the tree instead.
- edited neighbors: discards what most of the 3 nearest neighbors contradict (D. L. Wilson 1972).
- confident learning: cleanlab's `find_label_issues`, which prunes by noise rate (C. Northcutt, L.
  Jiang, I. Chuang, Confident Learning, JAIR 70, 2021), with probabilities out of sample from five
  folds, by logistic regression, by 5 nearest neighbors and by the tree itself. It is written out
  below; ``--cleanlab`` uses the package instead, where it is installed, and compares the two.
- the truth: discards exactly the mistaken ones.

    scripts/python research/unlearning.py --json unlearning.json
    scripts/python research/unlearning.py --quick
"""

from __future__ import annotations

import json as js
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean, median, stdev
from typing import Annotated, Any

import numpy as np
import typer
from sklearn.base import BaseEstimator
from sklearn.datasets import load_breast_cancer, load_digits, load_iris, load_wine
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import StratifiedKFold, cross_val_predict
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from hitab_core import Example, Scale, TransitionTree, TransitionTreeClassifier
from hitab_core.advice.proposals import Correction, ProposalKind
from hitab_core.advice.unlearning import propose
from hitab_core.arrays import Booleans, Floats, Integers

DATA = {
    "iris": load_iris,
    "wine": load_wine,
    "breast cancer": load_breast_cancer,
    "digits": load_digits,
}
MOST = 600
"""Of larger data sets a random part is taken."""

SHARES = {"sparse": 0.2, "plenty": 0.5}
"""Share of the data that is examples."""

CORRECTING, TESTING = 0.2, 0.3
"""Shares of the data that corrections come from, and that test."""

RATES = (0.05, 0.1, 0.2)
"""Shares of the examples whose labels are wrong."""


@dataclass(frozen=True)
class Task:
    """A split data set with label noise.

    Attributes:
        X, y: examples, some with wrong labels.
        wrong: which ones these are.
        corrected_X, corrected_y, decided: clean examples that the tree misclassifies, and how.
        test_X, test_y: clean.
        classes: number of classes.
    """

    X: Floats
    y: Integers
    wrong: Booleans
    corrected_X: Floats
    corrected_y: Integers
    decided: Integers
    test_X: Floats
    test_y: Integers
    classes: int

    def everything(self) -> tuple[Floats, Integers]:
        """Return examples and, after them, corrections."""
        X = np.vstack([self.X, self.corrected_X])
        return X, np.concatenate([self.y, self.corrected_y])


def task(data: str, share: float, rate: float, seed: int) -> Task:
    """Return the task of a seed."""
    random = np.random.default_rng(seed)
    X, y = DATA[data](return_X_y=True)
    some = random.permutation(len(y))[:MOST]
    X, y = X[some], y[some]
    n = len(y)
    first, second, last = int(share * n), int((share + CORRECTING) * n), int((1 - TESTING) * n)
    classes = int(y.max()) + 1
    told = y[:first].copy()
    wrong = np.zeros(first, np.bool_)
    for i in random.permutation(first)[: round(rate * first)]:
        told[i] = random.choice([c for c in range(classes) if c != told[i]])
        wrong[i] = True
    decided = TransitionTree().fit(X[:first], told).predict(X[first:second])
    missed = decided != y[first:second]
    return Task(
        X[:first],
        told,
        wrong,
        X[first:second][missed],
        y[first:second][missed],
        decided[missed],
        X[last:],
        y[last:],
        classes,
    )


def ours(given: Task) -> Booleans:
    """Return which examples are proposed as mistakes."""
    examples = [
        Example("S", tuple(x), str(label), number=n, command=n)
        for n, (x, label) in enumerate(zip(given.X.tolist(), given.y, strict=True), 1)
    ]
    corrections = [
        Correction("S", tuple(x), str(wrong), str(right))
        for x, wrong, right in zip(
            given.corrected_X.tolist(), given.decided, given.corrected_y, strict=True
        )
    ]
    discarded = np.zeros(len(examples), np.bool_)
    for proposal in propose(examples, [Scale()] * given.X.shape[1], corrections):
        if proposal.kind is ProposalKind.MISTAKE:
            discarded[[number - 1 for number in proposal.examples]] = True
    return discarded


def edited(given: Task, k: int = 3) -> Booleans:
    """Return which examples most of their k nearest neighbors contradict."""
    X, y = given.everything()
    Z = StandardScaler().fit_transform(X)
    apart = ((Z[:, None] - Z[None]) ** 2).sum(axis=-1)
    np.fill_diagonal(apart, np.inf)
    nearest = np.argsort(apart, axis=1, kind="stable")[: len(given.y), :k]
    votes = [np.bincount(y[row], minlength=given.classes).argmax() for row in nearest]
    return np.asarray(np.array(votes) != given.y)


def out_of_sample(given: Task, classifier: BaseEstimator) -> tuple[Integers, Floats]:
    """Return the labels and their probabilities by classifiers that have not seen them."""
    X, y = given.everything()
    folds = max(2, min(5, int(np.bincount(y, minlength=given.classes).min())))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of rare classes
        p = cross_val_predict(
            classifier,
            X,
            y,
            cv=StratifiedKFold(folds, shuffle=True, random_state=0),
            method="predict_proba",
        )
    return y, p


def label_issues(y: Integers, p: Floats) -> Booleans:
    """Return which labels confident learning would prune, by noise rate.

    The confident joint counts examples of a given label by the true label that they confidently
    have: the most probable of those with at least the average probability that they have where
    they are given. From each given label as many are pruned as the joint says are of another one:
    those with the largest margin of that over the given one.
    """
    k = p.shape[1]
    given = [y == label for label in range(k)]
    average = np.array(
        [p[g, label].mean() if g.any() else np.inf for label, g in enumerate(given)]
    )
    confident = np.where(p >= average - 1e-6, p, -1.0)
    truly = np.where(confident.max(axis=1) >= 0, confident.argmax(axis=1), -1)
    joint = np.zeros((k, k))
    np.add.at(joint, (y[truly >= 0], truly[truly >= 0]), 1)
    np.fill_diagonal(joint, np.maximum(joint.diagonal(), 1))
    counts = np.array([g.sum() for g in given])
    joint *= (counts / joint.sum(axis=1))[:, None]
    issues = np.zeros(len(y), np.bool_)
    for label in range(k):
        rows = np.flatnonzero(given[label])
        if len(rows) <= 1:
            continue
        for other in range(k):
            most = int(np.rint(joint[label, other]))
            if other != label and most > 0:
                margin = p[rows, other] - p[rows, label]
                issues[rows[np.argsort(-margin, kind="stable")[:most]]] = True
    return issues & (p.argmax(axis=1) != y)


def confident(classifier: BaseEstimator, issues: Callable[..., Any]) -> Callable[[Task], Booleans]:
    """Return confident learning by a classifier."""
    return lambda given: np.asarray(issues(*out_of_sample(given, classifier))[: len(given.y)])


def figures(given: Task, discarded: Booleans, *, prune: bool = False) -> dict[str, float]:
    """Return how good the tree without some examples is, and what was discarded."""
    X, y = given.everything()
    kept = np.concatenate([~discarded, np.ones(len(given.corrected_y), np.bool_)])
    tree = TransitionTree(prune=prune).fit(X[kept], y[kept])
    return {
        "accuracy": float((tree.predict(given.test_X) == given.test_y).mean()),
        "found": float(discarded[given.wrong].mean()),
        "lost": float(discarded[~given.wrong].sum()),
        "corrections": float(len(given.corrected_y)),
    }


def methods(issues: Callable[..., Any]) -> dict[str, Callable[[Task], dict[str, float]]]:
    """Return what is compared, by name."""

    def discarding(which: Callable[[Task], Booleans]) -> Callable[[Task], dict[str, float]]:
        return lambda given: figures(given, which(given))

    def nothing(given: Task) -> Booleans:
        return np.zeros(len(given.y), np.bool_)

    scaled = StandardScaler
    return {
        "as taught": discarding(nothing),
        "ours": discarding(ours),
        "C4.5 pruning": lambda given: figures(given, nothing(given), prune=True),
        "edited neighbors": discarding(edited),
        "confident, logistic": discarding(
            confident(make_pipeline(scaled(), LogisticRegression(max_iter=500)), issues)
        ),
        "confident, neighbors": discarding(
            confident(make_pipeline(scaled(), KNeighborsClassifier(5, weights="distance")), issues)
        ),
        "confident, tree": discarding(confident(TransitionTreeClassifier(), issues)),
        "the truth": discarding(lambda given: given.wrong),
    }


def summary(rows: list[dict[str, float]]) -> dict[str, float]:
    """Return means, with the standard error of the accuracy, and the median of examples lost."""
    accuracies = [row["accuracy"] for row in rows]
    return {
        "accuracy": round(fmean(accuracies), 4),
        "se": round(stdev(accuracies) / len(rows) ** 0.5, 4),
        "found": round(fmean(row["found"] for row in rows), 3),
        "lost": round(fmean(row["lost"] for row in rows), 2),
        "lost_median": median(row["lost"] for row in rows),
        "corrections": round(fmean(row["corrections"] for row in rows), 1),
    }


def ahead(best: list[float], other: list[float]) -> tuple[float, float]:
    """Return the mean difference of accuracies on equal tasks, and its standard error."""
    differences = [a - b for a, b in zip(best, other, strict=True)]
    return fmean(differences), stdev(differences) / len(differences) ** 0.5


def show(title: str, by_method: dict[str, list[dict[str, float]]]) -> dict[str, Any]:
    """Print the figures of one group of tasks and return them."""
    print(title, flush=True)
    shown = {}
    for method, rows in by_method.items():
        shown[method] = s = summary(rows)
        print(
            f"  {method:20} accuracy {s['accuracy']:.4f} ± {s['se']:.4f}  "
            f"noise found {s['found']:4.0%}  clean lost {s['lost']:5.2f} "
            f"(median {s['lost_median']:g})",
            flush=True,
        )
    return shown


def main(
    seeds: Annotated[int, typer.Option(help="How many seeds.", min=2)] = 20,
    first: Annotated[int, typer.Option(help="The first seed.")] = 100,
    quick: Annotated[bool, typer.Option(help="Two small data sets, 3 seeds.")] = False,
    cleanlab: Annotated[bool, typer.Option(help="Use the package cleanlab.")] = False,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
) -> None:
    """Compare methods of unlearning on data sets with label noise."""
    issues: Callable[..., Any] = label_issues
    if cleanlab:
        from cleanlab.filter import find_label_issues  # type: ignore[import-not-found]

        def checked(y: Integers, p: Floats) -> Any:
            theirs = find_label_issues(y, p, n_jobs=1)
            differ = int(np.count_nonzero(theirs != label_issues(y, p)))
            disagreed.append(differ)
            return theirs

        disagreed: list[int] = []
        issues = checked
    data = ["iris", "wine"] if quick else list(DATA)
    seeds = 3 if quick else seeds
    compared = methods(issues)
    began = time.monotonic()
    overall: dict[str, list[dict[str, float]]] = {name: [] for name in compared}
    groups: dict[str, Any] = {}
    for name in data:
        for amount, share in SHARES.items():
            for rate in RATES:
                by_method: dict[str, list[dict[str, float]]] = {m: [] for m in compared}
                for seed in range(first, first + seeds):
                    given = task(name, share, rate, seed)
                    for method, measure in compared.items():
                        by_method[method].append(measure(given))
                title = f"{name}, {amount} ({len(given.y)} examples), {rate:.0%} noise"
                groups[title] = show(title, by_method)
                for method, rows in by_method.items():
                    overall[method] += rows
    total = show(f"all, {seeds} seeds from {first}", overall)
    mine = [row["accuracy"] for row in overall["ours"]]
    gains = {}
    for method, rows in overall.items():
        if method != "ours":
            gains[method] = ahead(mine, [row["accuracy"] for row in rows])
            print(f"  ours minus {method:20} {gains[method][0]:+.4f} ± {gains[method][1]:.4f}")
    if cleanlab:
        print(
            f"  cleanlab and the code here differ in {sum(disagreed)} examples, in "
            f"{sum(d > 0 for d in disagreed)} of {len(disagreed)} runs"
        )
    if json:
        written = {
            "seeds": seeds,
            "first": first,
            "groups": groups,
            "all": total,
            "ours_minus": gains,
            "wall_s": round(time.monotonic() - began, 1),
        }
        Path(json).write_text(js.dumps(written, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    typer.run(main)
