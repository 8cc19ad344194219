"""Expectations in the notation of people, with values in the units of displays."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from hitab_core import (
    OWN_NAMES,
    RADIANS,
    START,
    Domain,
    FeatureKind,
    LibraryError,
    Term,
    has,
    shown_unit,
    shown_value,
    unknown,
)
from hitab_core.library import BehaviorFile, Expectation

BOOLEANS = {"yes": 1.0, "true": 1.0, "1": 1.0, "no": 0.0, "false": 0.0, "0": 0.0}


def expected(
    file: BehaviorFile, domain: Domain, words: Sequence[str], example: int, name: str
) -> Expectation:
    """Return a new expectation of a behavior.

    Args:
        file: file of the behavior.
        domain: domain of the behavior.
        words: state, next state, and ``FEATURE=VALUE`` for each feature of the situation.
        example: number of an example to use instead of the words; 0 for none.
        name: name of the expectation; empty for a numbered name.

    Raises:
        LibraryError: if a state or an example is unknown, or the name is taken.
    """
    taken = {one.name for one in file.expectations}
    numbered = (f"expectation_{number}" for number in range(1, len(taken) + 2))
    name = name or next(one for one in numbered if one not in taken)
    if name in taken:
        raise LibraryError(f'{file.name} has an expectation "{name}" already; choose another name')
    automaton = file.automaton
    if example:
        found = {one.number: one for one in automaton.examples}
        if example not in found:
            numbers = [str(number) for number in found]
            raise LibraryError(f"{file.name} has no example {example} {has(numbers)}")
        return Expectation.of_example(name, found[example], automaton)
    if len(words) < 2:
        raise LibraryError(
            f"say what {file.name} should decide: a state, the next one, and FEATURE=VALUE for "
            "each feature; or give --example"
        )
    state, to, *situation = words
    for label, known in ((state, (START, *automaton.labels)), (to, automaton.labels)):
        if label not in known:
            raise LibraryError(unknown("state", label, known, f" in {file.name}"))
    chosen = automaton.feature_labels
    features = {}
    for text in situation:
        feature, equals, value = text.rpartition("=")
        if not equals or feature not in chosen:
            raise LibraryError(
                f'"{text}" is not FEATURE=VALUE with a feature that decides {has(chosen, feature)}'
            )
        features[feature] = value_of(value, feature, domain)
    return Expectation(name, state, features, to)


def value_of(text: str, feature: str, domain: Domain) -> float:
    """Return a feature's value from its displayed form: an angle in degrees, yes or no, a name.

    Raises:
        LibraryError: if the text is not a value of the feature.
        VocabularyError: if there is no such feature.
    """
    name = Term.parse(feature).name
    if name not in (*domain.features, *OWN_NAMES):
        raise LibraryError(unknown("feature", name, domain.features))
    word = domain.feature(name)
    names: Mapping[str, float] = {}
    if word.kind is FeatureKind.BOOLEAN:
        names = BOOLEANS
    elif word.kind is FeatureKind.CATEGORICAL:
        names = {name: float(index) for index, name in enumerate(word.categories)}
    if names:
        if text not in names:
            raise LibraryError(f'"{text}" is no value of {feature} {has([*names], text)}')
        return names[text]
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise LibraryError(f'"{text}" is no value of {feature}; give a number')
    return math.radians(value) if word.unit == RADIANS else value


def forgotten(file: BehaviorFile, name: str) -> list[Expectation]:
    """Return the expectations of a behavior without the named one.

    Raises:
        LibraryError: if there is no such expectation.
    """
    kept = [one for one in file.expectations if one.name != name]
    if len(kept) == len(file.expectations):
        raise LibraryError(unknown("expectation", name, [one.name for one in kept]))
    return kept


def in_words(one: Expectation, domain: Domain) -> str:
    """Return an expectation for people to read."""
    values = [_shown(feature, value, domain) for feature, value in one.features.items()]
    seeing = f", with {', '.join(values)}" if values else ""
    return f"expects {one.name}: in {one.state}{seeing} -> {one.next_state}"


def _shown(feature: str, value: float, domain: Domain) -> str:
    word = domain.feature(Term.parse(feature).name)
    if word.kind is FeatureKind.BOOLEAN:
        return f"{feature} {'yes' if value else 'no'}"
    if word.kind is FeatureKind.CATEGORICAL:
        return f"{feature} {word.categories[int(value)]}"
    return f"{feature} {shown_value(value, word.unit):.4g} {shown_unit(word.unit)}".rstrip()
