"""Feature values for classifiers that accept only plain numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from hitab_core.domain import FeatureKind, Scale
from hitab_core.numeric.arrays import Floats


def encoding_of(X: Floats, scales: Sequence[Scale]) -> Callable[[Floats], Floats]:
    """Return an encoder of feature values, fitted to the values of examples.

    A continuous feature is standardized by the mean and standard deviation of the examples, since
    many classifiers measure distances, in which meters must not outweigh radians. A toroidal one
    becomes the cosine and sine of its angle, so that zero is not special. A categorical one is
    one-hot encoded; a boolean one stays 0 or 1.

    Args:
        X: shape (n, m), of the examples.
        scales: scale of each of the m features.

    Returns:
        A function from shape (k, m) to shape (k, number of columns).
    """
    means, deviations = X.mean(axis=0), X.std(axis=0)
    deviations[deviations == 0] = 1.0

    def encoded(values: Floats) -> Floats:
        columns: list[Floats] = []
        for f, scale in enumerate(scales):
            column = values[:, f]
            if scale.kind is FeatureKind.TOROIDAL:
                angle = column * (2 * np.pi / scale.period)
                columns += [np.cos(angle), np.sin(angle)]
            elif scale.kind is FeatureKind.CATEGORICAL:
                count = len(scale.categories) or int(X[:, f].max()) + 1
                columns += [column == c for c in range(count)]
            elif scale.kind is FeatureKind.CONTINUOUS:
                columns.append((column - means[f]) / deviations[f])
            else:
                columns.append(column)
        return np.column_stack(columns) if columns else np.zeros((len(values), 1))

    return encoded
