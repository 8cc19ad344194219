"""Feature values for classifiers that accept only plain numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hitab_core.arrays import Floats
from hitab_core.domain import FeatureKind, Scale


@dataclass(frozen=True, slots=True)
class FeatureEncoding:
    """Encodes feature values for a classifier that accepts only plain numbers.

    A continuous feature is standardized by the mean and standard deviation of the examples, since
    many classifiers measure distances, in which meters must not outweigh radians. A toroidal one
    becomes the cosine and sine of its angle, so that zero is not special. A categorical one is
    one-hot encoded; a boolean one stays 0 or 1.
    """

    scales: tuple[Scale, ...]
    means: tuple[float, ...]
    deviations: tuple[float, ...]
    n_categories: tuple[int, ...]

    @classmethod
    def of(cls, X: Floats, scales: Sequence[Scale]) -> FeatureEncoding:
        """Fit the encoding to examples, shape (n, m)."""
        means, deviations, largest = X.mean(axis=0), X.std(axis=0), X.max(axis=0)
        n_categories = tuple(
            len(scale.categories) or int(largest[f]) + 1
            if scale.kind is FeatureKind.CATEGORICAL
            else 0
            for f, scale in enumerate(scales)
        )
        return cls(
            tuple(scales),
            tuple(means.tolist()),
            tuple(np.where(deviations > 0, deviations, 1.0).tolist()),
            n_categories,
        )

    def __call__(self, X: Floats) -> Floats:
        """Return the encoded values: shape (n, number of columns), from shape (n, m)."""
        columns: list[Floats] = []
        for f, scale in enumerate(self.scales):
            values = X[:, f]
            if scale.kind is FeatureKind.TOROIDAL:
                angle = values * (2 * np.pi / scale.period)
                columns += [np.cos(angle), np.sin(angle)]
            elif scale.kind is FeatureKind.CATEGORICAL:
                columns += [values == c for c in range(self.n_categories[f])]
            elif scale.kind is FeatureKind.CONTINUOUS:
                columns.append((values - self.means[f]) / self.deviations[f])
            else:
                columns.append(values)
        return np.column_stack(columns) if columns else np.zeros((len(X), 1))
