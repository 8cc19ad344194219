"""From examples to transition functions: one per state, from that state's examples alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from hitab_core.domain import Scale
from hitab_core.errors import TrainingError, VocabularyError, has
from hitab_core.example import Example
from hitab_core.learning.classifier_replacement import classifier_maker, learn_replacement
from hitab_core.learning.classifier_spec import ClassifierSpec
from hitab_core.learning.feature_values import feature_values
from hitab_core.learning.memo import LearningMemo
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.transition_function import LearnedTransition

TREE = "tree"

_MEMO = LearningMemo()
"""Of the process. It changes nothing but how long learning takes."""


Learn = Callable[[ArrayLike, Sequence[str], Sequence[bool]], LearnedTransition]
"""``learn(X, y, default)`` learns from the examples of one state."""


def learner(classifier: str, scales: Sequence[Scale], names: Sequence[str] | None = None) -> Learn:
    """Return what learns the transition function of a state.

    Args:
        classifier: ``tree``, with `TransitionTree`'s keywords where wanted, such as
            ``tree(prune=True)``, or a scikit-learn classifier such as
            ``sklearn.neighbors.KNeighborsClassifier(n_neighbors=1)``. To the latter a default
            example is an example like any other.
        scales: for each feature how its values compare.
        names: names of the features, for errors.

    Raises:
        VocabularyError: if there is no such classifier.
    """
    spec = ClassifierSpec.parse(classifier)
    if spec.name != TREE:
        make = classifier_maker(spec)
        return lambda X, y, default: learn_replacement(spec, make, scales, X, y, names)
    known = sorted({*TransitionTree().get_params()} - {"scales", "feature_names"})
    for name in spec.arguments:
        if name not in known:
            raise VocabularyError(f'the classifier "tree" has no parameter "{name}" {has(known)}')

    def learn_tree(X: ArrayLike, y: Sequence[str], default: Sequence[bool]) -> LearnedTransition:
        tree = TransitionTree(scales, feature_names=names, **spec.arguments)
        try:
            return tree.fit(X, y, default)
        except (ValueError, TypeError) as error:
            raise TrainingError(f'"{spec}" cannot learn: {error}') from error

    return learn_tree


def learn_transition(
    classifier: str,
    scales: Sequence[Scale],
    X: ArrayLike,
    y: Sequence[str],
    default: Sequence[bool] | None = None,
    names: Sequence[str] | None = None,
) -> LearnedTransition:
    """Learn the transition function of one state.

    Args:
        classifier: see `learner`.
        scales: for each of the m features how its values compare.
        X: shape (n, m), feature values, n at least 1.
        y: labels of the next states, n of them.
        default: whether each example is a default one; None: none is.
        names: names of the features, for errors.

    Raises:
        FeatureValueError: naming a feature whose value is missing or impossible.
        VocabularyError: if there is no such classifier.
        TrainingError: if the classifier cannot learn from these examples.
    """
    is_default = [False] * len(y) if default is None else default
    return learner(classifier, scales, names)(X, y, is_default)


def learn_transitions(
    examples: Sequence[Example],
    scales: Sequence[Scale],
    classifier: str = TREE,
    names: Sequence[str] | None = None,
) -> dict[str, LearnedTransition]:
    """Learn one transition function for each state that has examples, in order of appearance.

    A function that is learned from the same again is the same object, which nobody must change;
    see `hitab_core.learning.memo`.

    Args:
        examples: of any states.
        scales: for each feature how its values compare.
        classifier: see `learner`.
        names: names of the features, for errors.

    Raises:
        FeatureValueError: naming a feature and an example whose value is missing or impossible.
        VocabularyError: if there is no such classifier.
        TrainingError: if an example has not one value per feature, or if the classifier cannot
            learn from a state's examples, naming the state.
    """
    learn = learner(classifier, scales, names)
    by_state: dict[str, list[Example]] = {}
    for example in examples:
        if len(example.features) != len(scales):
            raise TrainingError(
                f'example {example.number} of state "{example.state}" has '
                f"{len(example.features)} values for {len(scales)} features; delete it"
            )
        by_state.setdefault(example.state, []).append(example)
    functions: dict[str, LearnedTransition] = {}
    for state, own in by_state.items():
        X = np.array([example.features for example in own], dtype=np.float64)
        rows = [f'example {example.number} of state "{state}"' for example in own]
        feature_values(X, scales, names, rows)  # here errors can name the example
        y = [example.next_state for example in own]
        default = [example.is_default for example in own]
        try:
            functions[state] = _named(
                _MEMO.learned(classifier, scales, X, y, default, partial(learn, X, y, default)),
                names,
            )
        except TrainingError as error:
            raise TrainingError(f'state "{state}": {error}') from error
    return functions


def _named(function: LearnedTransition, names: Sequence[str] | None) -> LearnedTransition:
    """Return a function that calls its features so in errors."""
    if not isinstance(function, TransitionTree) or function.feature_names == names:
        return function
    renamed = copy(function)
    renamed.feature_names = names
    return renamed
