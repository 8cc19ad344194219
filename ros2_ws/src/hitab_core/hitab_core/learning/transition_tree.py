"""The classifier that learns a transition function: a C4.5 tree with probabilities at its leaves.

It behaves like a scikit-learn estimator without importing scikit-learn; `scikit_learn` wraps it as
a checked one.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import partial
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hitab_core.domain import FeatureKind, Scale
from hitab_core.learning import tree_text
from hitab_core.learning.boundaries import on_circle
from hitab_core.learning.compiled_tree import compiled, decider, leaf_choice
from hitab_core.learning.feature_values import check_scales, feature_values
from hitab_core.learning.missing_values import distribution_at, likely_state
from hitab_core.learning.splits import Choose, choose_split
from hitab_core.learning.tree_growth import grow
from hitab_core.learning.tree_nodes import Leaf, Node, described, nodes
from hitab_core.learning.tree_pruning import prune
from hitab_core.learning.tree_text import Rule
from hitab_core.numeric.arrays import Floats
from hitab_core.texts.errors import VocabularyError
from hitab_core.texts.vocabulary import has
from hitab_core.transition_function import Decide, Explanation


@dataclass(eq=False)
class TransitionTree:
    """Decision tree that maps feature values to a distribution over next states.

    It is C4.5 with HiTAB's two changes: a leaf keeps the distribution of its examples, and a
    boundary between a default and a demonstrated example lies beside the latter
    (`hitab_core.learning.boundaries`). `hitab_core.learning.splits` lists and rates the splits.

    A missing value (None or NaN) is no error: an example without a value of a tested feature
    counts in every branch in part (`tree_growth`), and so does the answer (`missing_values`).

    The same examples in the same order give the same tree on any machine. The order matters only
    between equally good arcs of a toroidal feature.

    Parameters:
        scales: scale of each feature; None if all are continuous.
        min_samples_leaf: the fewest examples a branch may have; for a categorical feature, at
            least two branches must have as many.
        max_depth: the most tests on a path, or None for no limit.
        prune: whether to prune as C4.5 does. An unpruned tree reproduces all examples that do not
            contradict each other.
        confidence: confidence of pruning, in (0, 0.5]; smaller values prune more.
        boolean_first: whether ties between features are broken in favor of boolean and
            categorical ones.
        look_ahead: whether boolean and categorical features come before a boundary that would be
            shared (`hitab_core.learning.splits`).
        all_around: see `hitab_core.learning.splits.split_toroidal`.
        feature_names: names of the features, for errors.

    Attributes:
        classes_: shape (n_classes,), the labels seen, sorted.
        n_features_in_: number of features, m.
        scales_: scale of each feature.
        root_: the tree, see `hitab_core.learning.tree_nodes`.

    Examples:
        >>> tree = TransitionTree(feature_names=["DistanceTo(ball)"])
        >>> _ = tree.fit([[9.0], [1.0], [4.0]], ["GoFast", "Stop", "GoFast"])
        >>> tree.predict([[2.4], [2.6]]).tolist()
        ['Stop', 'GoFast']

    References:
        Paper, section 3. J. R. Quinlan, C4.5: Programs for Machine Learning, 1993.
    """

    scales: Sequence[Scale] | None = None
    _: KW_ONLY
    min_samples_leaf: int = 1
    max_depth: int | None = None
    prune: bool = False
    confidence: float = 0.25
    boolean_first: bool = True
    look_ahead: bool = True
    all_around: bool = False
    feature_names: Sequence[str] | None = None

    @classmethod
    def of(cls, root: Node, labels: Sequence[str], scales: Sequence[Scale]) -> Self:
        """Return a tree that was learned elsewhere.

        Args:
            root: see `hitab_core.learning.tree_nodes`.
            labels: labels of the next states, sorted.
            scales: scale of each feature.
        """
        tree = cls(scales)
        tree.classes_, tree.n_features_in_ = np.array(labels), len(scales)
        tree.scales_, tree.root_ = tuple(scales), root
        return tree

    def fit(
        self,
        X: ArrayLike,
        y: ArrayLike,
        default: ArrayLike | None = None,
        *,
        choose: Choose | None = None,
    ) -> Self:
        """Learn from examples.

        Args:
            X: shape (n, m), feature values in the features' own units, n at least 1; None or NaN
                if missing.
            y: shape (n,), labels of the next states.
            default: shape (n,), whether an example is a default one; None if none are.
            choose: chooses the split of a node, see `tree_growth.grow`; None for the split with
                the largest gain ratio, as C4.5.

        Raises:
            FeatureValueError: naming a feature with an infinite or out-of-scale value.
            VocabularyError: naming a toroidal feature without a period.
            ValueError: if shapes do not match or a parameter is out of range.
        """
        deepest = 0 if self.max_depth is None else self.max_depth
        if self.min_samples_leaf < 1 or deepest < 0 or not 0 < self.confidence <= 0.5:
            raise ValueError(
                f"{self!r}: min_samples_leaf must be at least 1, max_depth None or at least 0, "
                "confidence in (0, 0.5]"
            )
        n_columns = np.shape(X)[1] if np.ndim(X) == 2 else 0
        scales = tuple(self.scales) if self.scales is not None else (Scale(),) * n_columns
        check_scales(scales, self.feature_names)
        values = feature_values(X, scales, self.feature_names, may_miss=True) + 0.0  # no -0.0
        labels = np.asarray(y)
        is_default = np.asarray([False] * len(values) if default is None else default, np.bool_)
        if len(values) == 0 or not labels.shape == is_default.shape == (len(values),):
            raise ValueError(
                f"expected at least one example, each with a label and whether it is a default "
                f"one, got X {values.shape}, y {labels.shape}, default {is_default.shape}"
            )
        for f, scale in enumerate(scales):
            if scale.kind is FeatureKind.TOROIDAL:
                values[:, f] = [on_circle(v, scale.period) for v in values[:, f].tolist()]
        self.classes_: NDArray[Any]
        self.classes_, classes = np.unique(labels, return_inverse=True)
        self.n_features_in_ = len(scales)
        self.scales_ = scales
        self.root_: Node = grow(
            values,
            classes,
            is_default,
            len(self.classes_),
            scales,
            min_samples_leaf=self.min_samples_leaf,
            max_depth=self.max_depth,
            all_around=self.all_around,
            look_ahead=self.look_ahead,
            choose=choose or partial(choose_split, boolean_first=self.boolean_first),
        )
        if self.prune:
            self.root_ = prune(self.root_, self.confidence)
        return self

    def _fitted(self) -> Node:
        if not hasattr(self, "root_"):
            raise AttributeError("this TransitionTree has learned nothing yet; call fit first")
        return self.root_

    @property
    def labels(self) -> list[str]:
        """The labels of the next states, in the order of ``classes_``."""
        self._fitted()
        return [str(label) for label in self.classes_.tolist()]

    @property
    def features_used(self) -> tuple[int, ...]:
        """Indices of the features that the tree tests, ascending."""
        inner = (node for node in nodes(self._fitted()) if not isinstance(node, Leaf))
        return tuple(sorted({node.feature for node in inner}))

    def predict_proba(self, X: ArrayLike) -> Floats:
        """Return the probability of each class.

        Args:
            X: shape (n, m).

        Returns:
            shape (n, n_classes), columns in the order of ``classes_``.

        Raises:
            FeatureValueError: see `fit`.
        """
        root = self._fitted()
        values = feature_values(X, self.scales_, self.feature_names, may_miss=True).tolist()
        odds = [distribution_at(root, row.__getitem__) for row in values]
        return np.array(odds, np.float64).reshape(len(values), len(self.classes_))

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """Return the most probable class; on a tie, the first in ``classes_``.

        Args:
            X: shape (n, m).

        Raises:
            FeatureValueError: see `fit`.
        """
        probabilities = self.predict_proba(X)
        return np.asarray(self.classes_[probabilities.argmax(axis=1)])

    def compile(
        self, slots: Sequence[int], states: Mapping[str, int], *, most_probable: bool = False
    ) -> Decide:
        """Return the decision as a fast function; see `TransitionFunction.compile`.

        A leaf with several classes takes one draw, over its states in the order of their indices;
        a leaf with one class takes none, unless a value was missing on the way. Among equally
        probable states ``most_probable`` takes the lowest index.

        Raises:
            VocabularyError: if the tree leads to a state that is not in ``states``.
        """
        root = self._fitted()
        for label in self.labels:
            if label not in states:
                raise VocabularyError(
                    f'examples lead to "{label}", which is not a state {has(states)}'
                )
        indices = [states[label] for label in self.labels]
        tree = compiled(
            root, slots, lambda counts: leaf_choice(counts, indices, most_probable=most_probable)
        )
        return decider(tree, likely_state(root, slots, indices) if most_probable else None)

    def explain(self, values: Sequence[float], names: Sequence[str]) -> Explanation:
        """Explain the decision for a full feature vector; ``names`` name its features.

        The tests end at the first missing value (None or NaN); the distribution is exact.

        Raises:
            FeatureValueError: see `fit`.
        """
        root = self._fitted()
        (row,) = feature_values(
            [values], self.scales_, names, ["the values to explain"], may_miss=True
        ).tolist()
        why = self.retrace(row, names)
        odds = zip(self.labels, distribution_at(root, row.__getitem__), strict=True)
        return replace(why, distribution={label: p for label, p in odds if p > 0})

    def retrace(self, values: Sequence[float | None], names: Sequence[str]) -> Explanation:
        """Explain a past decision; see `TransitionFunction.retrace`.

        Only values on the path are used. At a value of None, and after one that was missing (NaN),
        the explanation ends with the distribution of the examples that got that far.
        """
        node = self._fitted()
        path: list[tree_text.Step] = []
        missing: list[str] = []
        features: list[int] = []
        while not isinstance(node, Leaf):
            value = values[node.feature]
            if value is None:
                break
            features.append(node.feature)
            if value != value:
                missing.append(f"{names[node.feature]} has no value")
                break
            branch = node.branch_for(value)
            path.append((node, branch))
            node = node.branches[branch] if branch is not None else Leaf(node.counts)
        return Explanation(
            (*tree_text.conditions(path, self.scales_, names), *missing),
            tuple(dict.fromkeys(features)),
            tree_text.distribution(node.counts, self.labels),
        )

    def rules(self, names: Sequence[str]) -> list[Rule]:
        """Return one readable rule per leaf, with the tests of a feature merged."""
        return tree_text.rules(self._fitted(), self.labels, self.scales_, names)

    def as_text(self, names: Sequence[str]) -> str:
        """Return a drawing of the tree, one line per branch."""
        return tree_text.drawing(self._fitted(), self.labels, self.scales_, names)

    def digest(self) -> str:
        """Return a SHA-256 in hexadecimal of the tree: labels, structure, counts, exact numbers.

        Equal trees have equal digests on all machines.
        """
        plain = [
            {**described(node), "branches": len(node.branches)} for node in nodes(self._fitted())
        ]
        text = json.dumps([self.labels, plain], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()
