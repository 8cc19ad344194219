"""Situations in words, for questions and remarks."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hitab_core.advice.evidence import Evidence
from hitab_core.domain import FeatureKind
from hitab_core.learning import tree_text
from hitab_core.texts.wording import DEGREES


def situation_in_words(
    evidence: Evidence, values: Sequence[float], features: Sequence[int]
) -> str:
    """Return values in words, such as ``Range = 2 m, not Far``; NaN is left out."""
    texts = []
    for f in features:
        value, name, scale = values[f], evidence.names[f], evidence.scales[f]
        if math.isnan(value):
            continue
        if scale.kind is FeatureKind.BOOLEAN:
            texts.append(name if value else f"not {name}")
        elif scale.kind is FeatureKind.CATEGORICAL:
            known = dict(enumerate(scale.categories))
            texts.append(f"{name} = {known.get(int(value), f'{value:.6g}')}")
        else:
            half = scale.kind is FeatureKind.TOROIDAL and value > scale.period / 2
            number = value - scale.period if half else value
            unit = _unit(evidence, f)
            if tree_text.in_degrees(scale):
                number, unit = round(math.degrees(number), 1) + 0.0, DEGREES
            texts.append(f"{name} = {number:.6g}{f' {unit}' if unit else ''}")
    return ", ".join(texts)


def _unit(evidence: Evidence, feature: int) -> str:
    return evidence.units[feature] if evidence.scales[feature].kind.is_measured else ""
