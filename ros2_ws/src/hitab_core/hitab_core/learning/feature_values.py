"""Feature values as arrays; impossible values, and where need be missing ones, are refused."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from hitab_core.domain import FeatureKind, Scale
from hitab_core.numeric.arrays import Booleans, Floats
from hitab_core.texts.errors import FeatureValueError, VocabularyError

_NEEDED = (
    "which is missing, and this classifier takes no missing values; leave out the example or the "
    'feature, or use "tree"'
)


def feature_called(index: int, names: Sequence[str] | None = None) -> str:
    """Return a feature's label for errors: its index and, if known, its name."""
    return f"feature {index}" + (f' "{names[index]}"' if names is not None else "")


def check_scales(scales: Sequence[Scale], names: Sequence[str] | None = None) -> None:
    """Check that toroidal features have a period.

    Raises:
        VocabularyError: naming one without a finite, positive period.
    """
    for f, scale in enumerate(scales):
        if scale.kind is FeatureKind.TOROIDAL and not 0 < scale.period < np.inf:
            raise VocabularyError(
                f"{feature_called(f, names)} is toroidal with period {scale.period}; "
                "give the length of its circle, such as 360 for degrees"
            )


def feature_values(
    X: ArrayLike,
    scales: Sequence[Scale],
    names: Sequence[str] | None = None,
    rows: Sequence[str] | None = None,
    *,
    may_miss: bool = False,
) -> Floats:
    """Return X as an array of floats, NaN where a value is missing.

    Args:
        X: shape (n, m), values; None or NaN if missing.
        scales: scale of each of the m features.
        names: names of the features, for errors.
        rows: labels of the rows for errors; ``row 0``, ``row 1``, ... by default.
        may_miss: whether values may be missing.

    Raises:
        FeatureValueError: naming the first feature with an infinite, an out-of-scale or, unless
            they may miss, a missing value.
        ValueError: if X has the wrong shape.
    """
    values = np.asarray(X, dtype=np.float64)
    if values.ndim != 2 or values.shape[1] != len(scales):
        raise ValueError(
            f"expected values of shape (n, {len(scales)}), one column per feature, "
            f"got shape {values.shape}"
        )
    for f, scale in enumerate(scales):
        column = values[:, f]
        missing = np.isnan(column)
        for wrong, why in (
            (np.isinf(column), "which is not finite"),
            (missing & (not may_miss), _NEEDED),
            (_outside(column, scale) & ~missing, _what_there_is(scale)),
        ):
            if wrong.any():
                row = int(np.argmax(wrong))
                where = rows[row] if rows is not None else f"row {row}"
                raise FeatureValueError(
                    f"{feature_called(f, names)} has value {column[row]} in {where}, {why}"
                )
    return values


def _outside(column: Floats, scale: Scale) -> Booleans:
    outside = np.zeros(len(column), np.bool_)
    if scale.kind is FeatureKind.BOOLEAN:
        outside = (column != 0) & (column != 1)
    elif scale.kind is FeatureKind.CATEGORICAL:
        limit = len(scale.categories) or np.inf
        outside = (column < 0) | (column >= limit) | (column != np.floor(column))
    return outside


def _what_there_is(scale: Scale) -> str:
    if scale.kind is FeatureKind.BOOLEAN:
        return "but it is boolean: 0 or 1"
    if scale.categories:
        return f"but its categories are 0 to {len(scale.categories) - 1}"
    return "but its categories are 0, 1, 2, ..."
