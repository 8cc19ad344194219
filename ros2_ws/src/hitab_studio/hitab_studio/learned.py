"""An agent's vocabulary and learned behaviors, as the page shows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from types import MappingProxyType
from typing import Any

from hitab_client import Learned
from hitab_core import (
    OWN_FEATURES,
    START,
    BoundedNumber,
    Example,
    Term,
    contradictions,
    with_numbers,
)
from hitab_ros.conversions import numbers_of_behaviors

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


def is_contradicted(examples: Sequence[Example]) -> dict[int, list[int]]:
    """Return the contradicted examples, each with the numbers of the contradicting ones.

    Two examples contradict each other if their states and values are equal but their next states
    differ.
    """
    return {
        example.number: [e.number for e in group if e.next_state != example.next_state]
        for group in contradictions(examples)
        for example in group
    }


def superseding(examples: Sequence[Example]) -> dict[int, list[int]]:
    """Return the superseded examples, each with the numbers of the superseding ones."""
    return {
        example.number: [e.number for e in examples if e.leaves and e.place == example.place]
        for example in examples
        if not example.is_learned
    }


@dataclass(frozen=True)
class Effect:
    """The effect of a change of examples.

    Attributes:
        rules_gone, rules_new: removed and added rules of the trees, as text.
        decisions: the examples with a changed decision, each with the former and the new one.
    """

    rules_gone: tuple[str, ...]
    rules_new: tuple[str, ...]
    decisions: tuple[tuple[Example, str, str], ...]


def effect(before: Learned, after: Learned) -> Effect:
    """Compare a behavior before and after a change of the examples or of the features."""
    old, new = _rules(before), _rules(after)
    former = {e.number: e for e in before.examples}
    decisions = []
    for example in after.examples:
        # The former decision in the example's situation uses the former features.
        then = example if before.features == after.features else former.get(example.number)
        if then is None or not example.is_learned:
            continue
        was = most_probable(before.decides(then.state, then.features))
        now = most_probable(after.decides(example.state, example.features))
        if was and was != now:
            decisions.append((example, was, now))
    return Effect(
        tuple(r for r in old if r not in new),
        tuple(r for r in new if r not in old),
        tuple(decisions),
    )


def most_probable(distribution: Mapping[str, float]) -> str:
    """Return the most probable state; "" if the distribution is empty."""
    return max(distribution, key=lambda s: distribution[s]) if distribution else ""


def _rules(learned: Learned) -> list[str]:
    rules = []
    for state in (START, *(learned.automaton.labels if learned.automaton else ())):
        tree = learned.trees.get(state)
        for rule in tree.rules(learned.features) if tree else ():
            words, _, _ = str(rule).rpartition(" (")  # without the number of examples
            rules.append(f"{state}: {words}")
    return rules
