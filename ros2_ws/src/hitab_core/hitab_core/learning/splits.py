"""The splits that a transition tree chooses from, and how it chooses: C4.5's gain ratio.

The candidate of each feature is its split with the largest information gain. Of the candidates
with at least average gain, the one with the largest gain ratio is taken. The ratio is used only to
compare features, as Quinlan does: used to place a threshold it would cut off single examples at
the ends. The penalty on continuous features of C4.5's release 8 is left out: it refuses splits
when examples are few, and a demonstrator gives few, each for a reason. Through the average, a
feature that is not chosen can still affect the choice.

Examples without a value of a feature do not take part in its split; they reduce its gain, see
`gain_ratio.gain_and_ratio`.

Ties (differences below `gain_ratio.TIE`, so that they are the same on all machines) are broken

- within a feature by the larger smallest branch, then on a line by the lower threshold, on a
  circle by the distance upwards from the node's first example, so never by where zero is;
- between features in favour of boolean and categorical ones, since a measured value nearly
  always differs a little between two examples, then in favour of the lower index; the former can
  be switched off (``boolean_first``).

One look ahead: a boolean or categorical feature comes before a measured one if the tree has no
more leaves for that. Below a boundary that comes first, a behavior shown with the ball would be
performed without it too; and a boundary that serves several classes is beside an example of only
one (a pass shown for takers at 2.5 m, where the ball was lost with a taker at 5 m, would be made
at 5 m).

References:
    J. R. Quinlan, C4.5: Programs for Machine Learning, Morgan Kaufmann 1993, chapters 2 and 3.
    J. R. Quinlan, Improved Use of Continuous Attributes in C4.5, JAIR 4, 1996.
    U. M. Fayyad, K. B. Irani, On the Handling of Continuous-Valued Attributes in Decision Tree
    Generation, Machine Learning 8, 1992.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hitab_core.domain import FeatureKind, Scale
from hitab_core.learning.boundaries import end_between, threshold_between
from hitab_core.learning.gain_ratio import TIE, Counts, best_of, gain_and_ratio, two_way_gains
from hitab_core.learning.tree_nodes import Arc, Categories, Test, Threshold
from hitab_core.numeric.arrays import Booleans, Floats, Integers


@dataclass(frozen=True, slots=True, eq=False)
class Split:
    """A way to split the examples of a node by one feature.

    Attributes:
        test: the test of the feature's value.
        gain: information gain in bits, at least 0.
        ratio: gain over split information.
        parts: the positions of each branch's examples, ascending.
    """

    test: Test
    gain: float
    ratio: float
    parts: tuple[Integers, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Examples:
    """The examples of a node that have a value of one feature.

    Attributes:
        values: shape (n,), the feature's values; toroidal ones in [0, period).
        classes: shape (n,), the classes as 0 .. n_classes - 1.
        default: shape (n,), whether an example is a default one.
        n_classes: number of classes, including those absent from this node.
        weights: shape (n,), the fraction of each example that is in this node, above 0; None for
            all of each.
        unknown: number of examples of the node without a value of the feature.
    """

    values: Floats
    classes: Integers
    default: Booleans
    n_classes: int
    weights: Floats | None = None
    unknown: float = 0

    def count(self, those: Booleans) -> float:
        """Return the number of some examples, weighted."""
        if self.weights is None:
            return int(np.count_nonzero(those))
        return float(self.weights[those].sum())

    def split(self, test: Test, counts: Counts, parts: tuple[Integers, ...]) -> Split:
        """Return the split by a test; ``counts`` are each branch's examples of each class."""
        return Split(test, *gain_and_ratio(counts, self.unknown), parts)


@dataclass(frozen=True, slots=True, eq=False)
class _Groups:
    """The distinct values, ascending, with their class counts and whether all are default."""

    values: list[float]
    group_of: Integers
    counts: Counts
    is_default: list[bool]

    @classmethod
    def of(cls, examples: Examples) -> _Groups:
        values, group_of = np.unique(examples.values, return_inverse=True)
        weights = examples.weights
        kind: type = np.int64 if weights is None else np.float64
        counts: Counts = np.zeros((len(values), examples.n_classes), kind)
        np.add.at(counts, (group_of, examples.classes), 1 if weights is None else weights)
        is_default = np.ones(len(values), np.bool_)
        np.logical_and.at(is_default, group_of, examples.default)
        return cls(values.tolist(), group_of, counts, is_default.tolist())


def _two_way(examples: Examples, first: Booleans, test: Threshold | Arc) -> Split:
    weights = examples.weights
    counts = np.array(
        [
            np.bincount(
                examples.classes[side],
                None if weights is None else weights[side],
                minlength=examples.n_classes,
            )
            for side in (first, ~first)
        ]
    )
    return examples.split(test, counts, (np.flatnonzero(first), np.flatnonzero(~first)))


def split_continuous(examples: Examples, min_branch: float = 1) -> Split | None:
    """Return the best split by a threshold between two adjacent distinct values, if any."""
    groups = _Groups.of(examples)
    if len(groups.values) < 2:
        return None
    below = groups.counts.cumsum(axis=0)[:-1]
    best = best_of(*two_way_gains(below.T, groups.counts.sum(axis=0), min_branch))
    if best is None:
        return None
    threshold = threshold_between(
        groups.values[best],
        groups.values[best + 1],
        below_is_default=groups.is_default[best],
        above_is_default=groups.is_default[best + 1],
    )
    return _two_way(examples, groups.group_of <= best, Threshold(threshold))


def split_toroidal(
    examples: Examples, period: float, min_branch: float = 1, *, all_around: bool = False
) -> Split | None:
    """Return the best split by an arc, if any.

    An end of an arc lies between two values that are neighbors on the circle; the inside is the
    side without the node's first example. All pairs of ends are compared, so the time grows with
    the square of the number of ends. Ends within a run of one class are skipped where they cannot
    gain most (Fayyad and Irani, 1992; their argument holds for each end by itself).

    Args:
        examples: see `split_by`.
        period: the length of the circle.
        min_branch: see `split_by`.
        all_around: whether default examples reach all around the circle, for comparison; see
            `hitab_core.learning.boundaries`.
    """
    groups = _Groups.of(examples)
    k = len(groups.values)
    if k < 2:
        return None
    # Places are measured from the first example's, so rotating all values changes nothing.
    origin = int(groups.group_of[0])
    counts = np.roll(groups.counts, -origin, axis=0)
    ends = np.arange(k)
    if min_branch <= 1:
        only = np.where((counts > 0).sum(axis=1) == 1, counts.argmax(axis=1), -1)
        ends = np.flatnonzero((only != np.roll(only, -1)) | (only < 0))
        if len(ends) < 2:
            return None  # there is only one class
    found = _best_arc(counts.cumsum(axis=0)[ends], counts.sum(axis=0), min_branch)
    if found is None:
        return None
    last_outside, last_inside = int(ends[found[0]]), int(ends[found[1]])

    def end(place: int, other: int) -> float:
        before, after = (place + origin) % k, (place + 1 + origin) % k
        values, is_default = groups.values, groups.is_default
        kept = math.inf
        if is_default[after] and not all_around:
            kept = (values[(other + 1 + origin) % k] - values[after]) % period
        elif is_default[before] and not all_around:
            kept = (values[before] - values[(other + origin) % k]) % period
        return end_between(
            values[before],
            values[after],
            period,
            before_is_default=is_default[before],
            after_is_default=is_default[after],
            kept=kept,
        )

    arc = Arc(end(last_outside, last_inside), end(last_inside, last_outside), period)

    places = (groups.group_of - origin) % k
    inside = (places > last_outside) & (places <= last_inside)
    return _two_way(examples, inside, arc)


def _best_arc(up_to: Counts, totals: Counts, min_branch: float) -> tuple[int, int] | None:
    """Return the two ends, in ascending order, of the best arc.

    Args:
        up_to: shape (n_ends, n_classes), the examples of each class before each end.
        totals, min_branch: see `two_way_gains`.
    """
    n_ends = len(up_to)
    at_once = max(1, 10_000 // n_ends)  # first ends; a block of pairs should fit in the cache
    best, found = -np.inf, []
    for start in range(0, n_ends - 1, at_once):
        firsts, seconds = up_to[start : start + at_once].T, up_to[start + 1 :].T
        # If the second end does not come after the first, nothing is inside.
        inside = np.maximum(seconds[:, None, :] - firsts[:, :, None], 0)
        gains, smaller = two_way_gains(inside, totals, min_branch)
        best = max(best, gains.max())
        if best > -np.inf:
            i, j = np.nonzero(gains >= best - TIE)
            found.append((gains[i, j], smaller[i, j], i + start, j + start + 1))
    if not found:
        return None
    gains, smaller, i, j = (np.concatenate(parts) for parts in zip(*found, strict=True))
    chosen = best_of(gains, smaller)
    return None if chosen is None else (int(i[chosen]), int(j[chosen]))


def split_boolean(examples: Examples, min_branch: float = 1) -> Split | None:
    """Return the split into false and true, if both were seen often enough."""
    false = examples.values <= 0.5
    if min(examples.count(false), examples.count(~false)) < min_branch:
        return None
    return _two_way(examples, false, Threshold(0.5))


def split_categorical(examples: Examples, min_branch: float = 1) -> Split | None:
    """Return the split into all categories seen, if two of them were seen often enough.

    Two, not all, as in C4.5: otherwise one rare category would make the feature useless.
    """
    groups = _Groups.of(examples)
    if np.count_nonzero(groups.counts.sum(axis=1) >= min_branch) < 2:
        return None
    parts = tuple(np.flatnonzero(groups.group_of == g) for g in range(len(groups.values)))
    test = Categories(tuple(int(value) for value in groups.values))
    return examples.split(test, groups.counts, parts)


def split_by(
    examples: Examples, scale: Scale, min_branch: float = 1, *, all_around: bool = False
) -> Split | None:
    """Return the best split by a feature of this scale; None if there is none.

    Args:
        examples: the node's examples that have a value of the feature.
        scale: scale of the feature.
        min_branch: the fewest examples a branch may have, above 0.
        all_around: see `split_toroidal`.
    """
    if scale.kind is FeatureKind.TOROIDAL:
        return split_toroidal(examples, scale.period, min_branch, all_around=all_around)
    if scale.kind is FeatureKind.BOOLEAN:
        return split_boolean(examples, min_branch)
    if scale.kind is FeatureKind.CATEGORICAL:
        return split_categorical(examples, min_branch)
    return split_continuous(examples, min_branch)


Chosen = tuple[int, Split]
"""A feature to split a node by, and its split."""

Leaves = Callable[[Chosen], int]
"""``leaves(chosen)`` returns how many leaves the tree has below a node that is split so."""

Choose = Callable[[Sequence[Split | None], Sequence[Scale], Leaves | None], Chosen | None]
"""``choose(candidates, scales, leaves)`` returns the feature and the split of a node, or None."""


def worthy_splits(candidates: Sequence[Split | None]) -> list[tuple[int, Split]]:
    """Return the features whose best split gains at least the average, with these splits.

    Args:
        candidates: each feature's best split; None where it has none.
    """
    found = [(f, split) for f, split in enumerate(candidates) if split is not None]
    if not found:
        return []
    average = sum(split.gain for _, split in found) / len(found)
    return [(f, split) for f, split in found if split.gain >= average - TIE]


def choose_split(
    candidates: Sequence[Split | None],
    scales: Sequence[Scale],
    leaves: Leaves | None = None,
    *,
    boolean_first: bool = True,
) -> Chosen | None:
    """Return the feature to split by and its split: C4.5's gain-ratio criterion.

    Args:
        candidates: each feature's best split; None where it has none.
        scales: scale of each feature.
        leaves: grows the trees below; None if the split is chosen without looking ahead.
        boolean_first: whether ties are broken in favor of boolean and categorical features before
            lower indices; and whether these come first if the tree has no more leaves for that.
    """
    worthy = worthy_splits(candidates)
    if not worthy:
        return None
    best = max(split.ratio for _, split in worthy)
    chosen = min(
        ((f, split) for f, split in worthy if split.ratio >= best - TIE),
        key=lambda choice: (boolean_first and scales[choice[0]].kind.is_measured, choice[0]),
    )
    if leaves is None or not boolean_first or not scales[chosen[0]].kind.is_measured:
        return chosen
    fewest = leaves(chosen)
    for feature, split in enumerate(candidates):
        if split is None or split.gain <= TIE or scales[feature].kind.is_measured:
            continue
        if leaves((feature, split)) <= fewest:
            return feature, split
    return chosen
