"""Learns transition functions: one per state, from that state's examples alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from hitab_core.automaton import START, Automaton
from hitab_core.domain import Domain, Scale
from hitab_core.example import Example
from hitab_core.learning.classifier_spec import ClassifierSpec
from hitab_core.learning.feature_values import feature_values
from hitab_core.learning.scikit_learn_adapter import classifier_maker, learn_with_classifier
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.learning.tree_text import Rule
from hitab_core.regression import learn_numbers
from hitab_core.texts.errors import TrainingError, VocabularyError
from hitab_core.texts.vocabulary import has
from hitab_core.texts.wording import quantity
from hitab_core.transition_function import LearnedTransition

TREE = "tree"

CACHED_MAX = 256
"""Maximum number of functions cached: saving learns from the same examples several times."""

Learn = Callable[[ArrayLike, Sequence[str], Sequence[bool]], LearnedTransition]
"""``learn(X, y, default)`` learns from the examples of one state."""


def learner(classifier: str, scales: Sequence[Scale], names: Sequence[str] | None = None) -> Learn:
    """Return a function that learns the transition function of a state.

    Args:
        classifier: ``tree``, optionally with `TransitionTree`'s keywords, such as
            ``tree(prune=True)``, or a scikit-learn classifier such as
            ``sklearn.neighbors.KNeighborsClassifier(n_neighbors=1)``, which treats default
            examples like any others.
        scales: scale of each feature.
        names: names of the features, for errors.

    Raises:
        VocabularyError: if there is no such classifier.
    """
    spec = ClassifierSpec.parse(classifier)
    if spec.name != TREE:
        make = classifier_maker(spec)
        return lambda X, y, default: learn_with_classifier(spec, make, scales, X, y, names)
    known = sorted({f.name for f in fields(TransitionTree)} - {"scales", "feature_names"})
    for name in spec.arguments:
        if name not in known:
            raise VocabularyError(
                f'the classifier "tree" has no parameter "{name}" {has(known, name)}'
            )

    def learn_tree(X: ArrayLike, y: Sequence[str], default: Sequence[bool]) -> LearnedTransition:
        tree = TransitionTree(scales, feature_names=names, **spec.arguments)
        try:
            return tree.fit(X, y, default)
        except (ValueError, TypeError) as error:
            raise TrainingError(f'"{spec}" cannot learn: {error}') from error

    return learn_tree


def relearned(automaton: Automaton, domain: Domain, classifier: str = TREE) -> Automaton:
    """Return an automaton learned from its examples; see `learn_transitions` for errors."""
    scales = [domain.scale_of(term) for term in automaton.features]
    names, examples = automaton.feature_labels, automaton.examples
    transitions = learn_transitions(examples, scales, classifier, names)
    numbers = learn_numbers(automaton.states, scales, examples, domain.numbers_of)
    return replace(automaton, transitions=transitions, numbers=numbers)


def rules_of(automaton: Automaton) -> dict[str, list[Rule]]:
    """Return the rules of each state that has a tree."""
    return {
        state: tree.rules(automaton.feature_labels)
        for state in (START, *automaton.labels)
        if isinstance(tree := automaton.transitions.get(state), TransitionTree)
    }


def learn_transitions(
    examples: Sequence[Example],
    scales: Sequence[Scale],
    classifier: str = TREE,
    names: Sequence[str] | None = None,
) -> dict[str, LearnedTransition]:
    """Learn a transition function for each state that has examples, in order of appearance.

    Learning from equal examples returns the same object, so do not modify it.

    Args:
        examples: examples of all states.
        scales: scale of each feature.
        classifier: see `learner`.
        names: names of the features, for errors.

    Raises:
        FeatureValueError: naming a feature and an example whose value is impossible, or missing if
            the classifier is not the tree.
        VocabularyError: if there is no such classifier.
        TrainingError: if an example does not have one value per feature, or, naming the state, if
            the classifier cannot learn from its examples.

    Examples:
        >>> examples = [Example("Start", (9.0,), "GoFast"), Example("GoFast", (1.0,), "Stop")]
        >>> functions = learn_transitions(examples, [Scale()])
        >>> {state: function.labels for state, function in functions.items()}
        {'Start': ['GoFast'], 'GoFast': ['Stop']}
    """
    learner(classifier, scales, names)  # which checks the name
    may_miss = ClassifierSpec.parse(classifier).name == TREE
    by_state: dict[str, list[Example]] = {}
    for example in examples:
        if len(example.features) != len(scales):
            raise TrainingError(
                f'example {example.number} of state "{example.state}" has '
                f"{quantity(len(example.features), 'value')} for "
                f"{quantity(len(scales), 'feature')}; delete it"
            )
        if example.is_learned:
            by_state.setdefault(example.state, []).append(example)
    functions: dict[str, LearnedTransition] = {}
    for state, own in by_state.items():
        X = np.array([example.features for example in own], dtype=np.float64)
        rows = [f'example {example.number} of state "{state}"' for example in own]
        # Checked here so that errors name the example.
        feature_values(X, scales, names, rows, may_miss=may_miss)
        y = tuple(example.next_state for example in own)
        default = tuple(example.is_default for example in own)
        called = None if names is None else tuple(names)
        try:
            functions[state] = _learned(classifier, tuple(scales), called, X.tobytes(), y, default)
        except TrainingError as error:
            raise TrainingError(f'state "{state}": {error}') from error
    return functions


@lru_cache(maxsize=CACHED_MAX)
def _learned(
    classifier: str,
    scales: tuple[Scale, ...],
    names: tuple[str, ...] | None,
    values: bytes,
    y: tuple[str, ...],
    default: tuple[bool, ...],
) -> LearnedTransition:
    """Learn from the values of an array, shape (n, m), and the behavior in each row."""
    X = np.frombuffer(values, np.float64).reshape(len(y), len(scales))
    return learner(classifier, scales, names)(X, y, default)
