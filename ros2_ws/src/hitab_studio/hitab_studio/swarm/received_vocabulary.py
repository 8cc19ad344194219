"""The vocabulary of an agent, as received from the agent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from types import MappingProxyType
from typing import Any

from hitab_core import (
    OWN_FEATURES,
    BoundedNumber,
    Term,
    with_numbers,
)
from hitab_ros.messages.conversions import numbers_of_behaviors

NO_ITEMS: Mapping[Any, Any] = MappingProxyType({})


@dataclass(frozen=True)
class Vocabulary:
    """The behaviors, features and targets of an agent, from `GetVocabulary`.

    Attributes:
        domain: name of the domain.
        behaviors, features, targets: labels with parameters, such as ``DistanceTo(X)``.
        behavior_descriptions: descriptions by behavior name, without parameters.
        units, kinds, feature_descriptions: by feature name, without parameters.
        trained, one_shot: names of the trained and of the one-shot behaviors.
        numbers: the numbers of each behavior that takes numbers, by name.
    """

    domain: str = ""
    behaviors: tuple[str, ...] = ()
    behavior_descriptions: Mapping[str, str] = field(default_factory=lambda: NO_ITEMS)
    trained: frozenset[str] = frozenset()
    one_shot: frozenset[str] = frozenset()
    numbers: Mapping[str, tuple[BoundedNumber, ...]] = field(default_factory=lambda: NO_ITEMS)
    features: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=lambda: NO_ITEMS)
    kinds: Mapping[str, str] = field(default_factory=lambda: NO_ITEMS)
    feature_descriptions: Mapping[str, str] = field(default_factory=lambda: NO_ITEMS)
    targets: tuple[str, ...] = ()

    @classmethod
    def of(cls, answer: Any) -> Vocabulary:
        """Return the vocabulary in an answer of `GetVocabulary`."""
        return cls(
            domain=answer.domain,
            behaviors=tuple(b.name for b in answer.behaviors),
            behavior_descriptions=_by_name(answer.behaviors, "description"),
            trained=frozenset(Term.parse(b.name).name for b in answer.behaviors if b.trained),
            one_shot=frozenset(Term.parse(b.name).name for b in answer.behaviors if b.one_shot),
            numbers=numbers_of_behaviors(answer.behaviors),
            features=tuple(f.name for f in answer.features),
            units=_by_name(answer.features, "unit"),
            kinds=_by_name(answer.features, "kind"),
            feature_descriptions=_by_name(answer.features, "description"),
            targets=tuple(answer.targets),
        )

    def numbers_of(self, behavior: str) -> tuple[BoundedNumber, ...]:
        """Return the numbers that a behavior takes."""
        return self.numbers.get(Term.parse(behavior).name, ())

    def commandable(self, behavior: str) -> str:
        """Return a behavior with initial numbers, each in the middle of its bounds."""
        term, numbers = Term.parse(behavior), self.numbers_of(behavior)
        return str(with_numbers(term, [(n.low + n.high) / 2.0 for n in numbers], numbers))


def terms(labels: Sequence[str], arguments: Sequence[str]) -> list[tuple[str, Term]]:
    """Return pairs of a label and a term: each label with every choice of targets.

    A flag in parentheses is not a parameter: ``SecondsSince(Done)`` has no choice.
    """
    found = []
    for label in labels:
        term = Term.parse(label)
        if term in OWN_FEATURES:
            found.append((label, term))
        else:
            choices = product(arguments, repeat=len(term.arguments))
            found += [(label, Term(term.name, choice)) for choice in choices]
    return found


def _by_name(words: Sequence[Any], what: str) -> Mapping[str, str]:
    """Return a field of each behavior or feature, by name without parameters."""
    return MappingProxyType({Term.parse(word.name).name: getattr(word, what) for word in words})
