"""Checks that an example, which may be edited by hand, makes sense in its automaton."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from hitab_core.automaton import START
from hitab_core.domain import FeatureKind, Scale
from hitab_core.example import Example
from hitab_core.vocabulary import has
from hitab_core.wording import quantity


def wrong_with(example: Example, labels: Sequence[str], scales: Sequence[Scale]) -> Iterable[str]:
    """Yield the faults of an example, worded to follow ``example 7``.

    Args:
        example: to check.
        labels: of the automaton's states, without Start.
        scales: how the values of each feature of the automaton compare.
    """
    state, to = example.state, example.next_state
    if state not in (START, *labels):
        yield f'is of state "{state}", which is not listed {has([START, *labels], state)}'
    if to not in labels:
        yield f'goes to "{to}", which is not a listed state {has(labels, to)}'
    if example.is_default and to != state:
        yield "is a default example, but leaves its state; make it a demonstrated one"
    if len(example.features) != len(scales):
        values, features = (
            quantity(len(example.features), "value"),
            quantity(len(scales), "feature"),
        )
        yield f"has {values} for {features}; give one for each"
        return
    for i, (value, scale) in enumerate(zip(example.features, scales, strict=True), 1):
        if math.isnan(value):
            continue  # missing
        if math.isinf(value):
            yield f"has {value} as value {i}; write a finite number, or delete the example"
        elif scale.kind is FeatureKind.BOOLEAN and value not in (0.0, 1.0):
            yield f"has {value:g} as value {i}, which is boolean: 0 or 1"
        elif scale.kind is FeatureKind.CATEGORICAL and not (
            value.is_integer() and 0 <= value < (len(scale.categories) or math.inf)
        ):
            what_for = f"0 to {len(scale.categories) - 1}" if scale.categories else "0, 1, 2, ..."
            yield f"has {value:g} as value {i}, which is a category: {what_for}"
