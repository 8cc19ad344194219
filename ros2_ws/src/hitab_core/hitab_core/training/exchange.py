"""Exchanging the features of a training: the same examples, learned from other features.

Each example keeps whatever could be read in its situation, so a feature that was not chosen at
first has its values there.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from hitab_core.automaton import CLEARED
from hitab_core.example import Example
from hitab_core.term import Term
from hitab_core.texts.errors import TrainingError
from hitab_core.texts.vocabulary import has
from hitab_core.texts.wording import quantity, some
from hitab_core.training.trainer import Trainer
from hitab_core.training.undo import Edit


def exchanged(
    examples: Sequence[Example],
    before: Sequence[Term],
    features: Sequence[Term],
    readable: Sequence[Term],
    name: str,
) -> list[Example]:
    """Return the same examples with the values of other features.

    An example without a reading of a feature has NaN there, which is learned from as a missing
    value; some examples must have one.

    Args:
        examples: examples with values of ``before``.
        before: the features of their values.
        features: features of the new values.
        readable: names of their readings.
        name: name of the automaton, for errors.

    Raises:
        TrainingError: if no example has a value of a feature.
    """
    column = {term: i for i, term in enumerate(before)}
    reading = {term: i for i, term in enumerate(readable)}

    def value(example: Example, term: Term) -> float:
        if term in column:
            return example.features[column[term]]
        if term in reading and example.readings:
            return (
                0.0 if example.is_default and term in CLEARED else example.readings[reading[term]]
            )
        return math.nan

    after = [replace(e, features=tuple(value(e, term) for term in features)) for e in examples]
    missing = [
        str(term)
        for i, term in enumerate(features)
        if after and all(math.isnan(e.features[i]) for e in after)
    ]
    if missing:
        has_readings = any(example.readings for example in examples)
        kept = (*before, *readable) if has_readings else before
        raise TrainingError(
            f'the examples of "{name}" have no value for {some(missing)} {has(kept)}; '
            f"demonstrate {quantity(len(after), 'example')} again with this feature, or choose "
            "others"
        )
    return after


def exchange(trainer: Trainer, features: Sequence[Term]) -> Edit:
    """Prepare to learn from other features; see `exchanged`."""
    before, name = trainer.curriculum.features, trainer.curriculum.name
    after = exchanged(trainer.examples, before, features, trainer.history.readable, name)
    names = tuple(map(str, features))
    return replace(
        trainer.log.replacement(after, f"features {', '.join(names) or 'none'}"),
        features=names,
        features_before=tuple(map(str, before)),
    )


def realigned(
    examples: Sequence[Example], names: Sequence[Term], readable: Sequence[Term]
) -> tuple[Example, ...]:
    """Return examples with their readings in another order.

    Args:
        examples: examples with readings of ``names``.
        names: names of their readings.
        readable: names of the new readings; NaN where there is none.
    """
    if tuple(names) == tuple(readable):
        return tuple(examples)
    column: Mapping[Term, int] = {term: i for i, term in enumerate(names)}

    def readings(example: Example) -> tuple[float, ...]:
        if not example.readings:
            return ()
        own = example.readings
        return tuple(own[column[term]] if term in column else math.nan for term in readable)

    return tuple(replace(e, readings=readings(e)) for e in examples)
