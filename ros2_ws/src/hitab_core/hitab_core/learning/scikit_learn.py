"""The transition tree as a scikit-learn classifier, for model selection and comparison.

Optional: the only module of this package that imports scikit-learn at import time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from hitab_core.domain import Scale
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.numeric.arrays import Floats


class TransitionTreeClassifier(ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """`TransitionTree` with scikit-learn's input checks, errors and tags.

    The parameters are the same as of `TransitionTree`.

    Attributes:
        tree_: the fitted `TransitionTree`.
        classes_: shape (n_classes,), the labels seen, sorted.
        n_features_in_: number of features.
    """

    def __init__(
        self,
        scales: Sequence[Scale] | None = None,
        *,
        min_samples_leaf: int = 1,
        max_depth: int | None = None,
        prune: bool = False,
        confidence: float = 0.25,
        boolean_first: bool = True,
        look_ahead: bool = True,
        all_around: bool = False,
    ) -> None:
        """Store the parameters; `fit` checks them."""
        self.scales = scales
        self.min_samples_leaf = min_samples_leaf
        self.max_depth = max_depth
        self.prune = prune
        self.confidence = confidence
        self.boolean_first = boolean_first
        self.look_ahead = look_ahead
        self.all_around = all_around

    def fit(self, X: ArrayLike, y: ArrayLike, default: ArrayLike | None = None) -> Self:
        """Learn from examples; see `TransitionTree.fit`."""
        X, y = validate_data(self, X, y, dtype=np.float64, ensure_all_finite="allow-nan")
        check_classification_targets(y)
        names = getattr(self, "feature_names_in_", None)
        self.tree_ = TransitionTree(
            feature_names=None if names is None else list(names), **self.get_params()
        ).fit(X, y, default)
        self.classes_ = self.tree_.classes_
        return self

    def __sklearn_tags__(self) -> Any:
        """Return scikit-learn's tags: values may be missing."""
        tags = super().__sklearn_tags__()
        tags.input_tags.allow_nan = True
        return tags

    def _questions(self, X: ArrayLike) -> Floats:
        checked: Floats = validate_data(
            self, X, dtype=np.float64, reset=False, ensure_all_finite="allow-nan"
        )
        return checked

    def predict_proba(self, X: ArrayLike) -> Floats:
        """Return the probability of each class, shape (n, n_classes), for X of shape (n, m)."""
        check_is_fitted(self)
        return self.tree_.predict_proba(self._questions(X))

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """Return the most probable class of each row, shape (n,), for X of shape (n, m)."""
        check_is_fitted(self)
        return self.tree_.predict(self._questions(X))
