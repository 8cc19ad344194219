"""The decisions that change with the examples."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import compress
from typing import NamedTuple

import numpy as np

from hitab_core.advice.evidence import Evidence, on_circles


class Changed(NamedTuple):
    """A decision that changes.

    Attributes:
        evidence: the examples of its state, as they will be.
        situation: situation of the decision.
        was, now: decision before and after: ``Stop``, ``stay``, or ``Stop or stay`` by chance.
    """

    evidence: Evidence
    situation: tuple[float, ...]
    was: str
    now: str


def changed(before: Evidence, after: Evidence, met: Sequence[Sequence[float]]) -> list[Changed]:
    """Return the changed decisions of a state in all met and shown situations, met ones first.

    Raises:
        FeatureValueError, VocabularyError, ValueError: see `Evidence.learn`.
    """
    shown = [row for evidence in (before, after) for row in evidence.values.tolist()]
    rows = [after.placed(row) for row in (*met, *shown)]
    rows = list({str(row): row for row in rows}.values())  # missing values are NaN
    decisions = zip(rows, decided(before, rows), decided(after, rows), strict=True)
    return [Changed(after, row, was, now) for row, was, now in decisions if was != now]


def decided(evidence: Evidence, situations: Sequence[Sequence[float]]) -> list[str]:
    """Return the decision in each situation, as in `Changed.was`.

    Raises:
        FeatureValueError, VocabularyError, ValueError: see `Evidence.learn`.
    """
    if not situations:
        return []
    values = np.array(situations, np.float64).reshape(len(situations), len(evidence.scales))
    values = on_circles(values, evidence.scales)
    tree = evidence.learn()
    labels = [evidence.state] if tree is None else tree.labels
    names = ["stay" if label == evidence.state else label for label in labels]
    # Without examples a state stays as it is.
    odds = np.ones((len(values), 1)) if tree is None else tree.predict_proba(values)
    return [" or ".join(compress(names, row > 0.0)) for row in odds]
