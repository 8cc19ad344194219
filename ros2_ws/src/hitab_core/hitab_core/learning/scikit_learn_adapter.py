"""A scikit-learn classifier in place of the tree, for comparison.

It is named by a text such as ``sklearn.neighbors.KNeighborsClassifier(n_neighbors=1)``, which is
parsed, never run: a class of scikit-learn, and keywords with literal values. scikit-learn is
imported when the first such function is learned, so agents that use trees do not need it. A
decision is the classifier's prediction, without a draw, and takes a thousand times as long as a
tree's.

A missing value is refused by name. It is not filled in: a made-up value would be learned like a
demonstrated one, and no person would notice.
"""

from __future__ import annotations

import hashlib
import inspect
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hitab_core.domain import Scale
from hitab_core.learning.classifier_spec import ClassifierSpec
from hitab_core.learning.feature_encoding import encoding_of
from hitab_core.learning.feature_values import check_scales, feature_values
from hitab_core.texts.errors import TrainingError, VocabularyError
from hitab_core.texts.wording import quantity
from hitab_core.transition_function import Decide, Explanation, HandWritten


def classifier_maker(spec: ClassifierSpec) -> Callable[[], Any]:
    """Return a function that makes a new, unfitted classifier, with ``random_state`` 0 by default.

    Raises:
        VocabularyError: if there is no such public classifier in scikit-learn, or it cannot be
            made.
    """
    module, _, attribute = spec.name.rpartition(".")
    why = ""
    if module.split(".")[0] == "sklearn" and "._" not in spec.name:
        try:
            from sklearn.base import ClassifierMixin  # here, so that trees do without it

            made = getattr(import_module(module), attribute, None)
            if isinstance(made, type) and issubclass(made, ClassifierMixin):
                arguments = dict(spec.arguments)
                if "random_state" in inspect.signature(made).parameters:
                    arguments.setdefault("random_state", 0)
                made(**arguments)
                return lambda: made(**arguments)
        except (ImportError, TypeError) as error:
            why = f" ({error})"
    raise VocabularyError(
        f'"{spec}" is not a classifier of scikit-learn{why}; write "tree", or its import path, '
        "such as sklearn.neighbors.KNeighborsClassifier"
    )


@dataclass(frozen=True)
class ClassifierFunction:
    """A transition function that a scikit-learn classifier has learned.

    Attributes:
        spec: the classifier, as text.
        predicts: the next state.
        data_digest: SHA-256 of the spec and the training data.
    """

    spec: str
    predicts: HandWritten
    data_digest: str

    @property
    def features_used(self) -> tuple[int, ...]:
        """All features; none if there is only one next state."""
        return self.predicts.features_used

    def compile(
        self, slots: Sequence[int], states: Mapping[str, int], *, most_probable: bool = False
    ) -> Decide:
        """Return the decision as a function; see `TransitionFunction.compile`."""
        return self.predicts.compile(slots, states)

    def explain(self, values: Sequence[float], names: Sequence[str]) -> Explanation:
        """Explain the decision for a full feature vector: only the classifier's name."""
        return replace(self.predicts.explain(values, names), tests=(self.spec,))

    def retrace(self, values: Sequence[float | None], names: Sequence[str]) -> Explanation:
        """Explain a past decision without predicting again."""
        return replace(self.predicts.retrace(values, names), tests=(self.spec,))

    def digest(self) -> str:
        """Return a SHA-256 of the spec and the training data; a classifier's state is private."""
        return self.data_digest


def learn_with_classifier(
    spec: ClassifierSpec,
    make: Callable[[], Any],
    scales: Sequence[Scale],
    X: ArrayLike,
    y: Sequence[str],
    names: Sequence[str] | None = None,
) -> ClassifierFunction:
    """Learn a transition function with a scikit-learn classifier.

    Args:
        spec: the classifier and its arguments.
        make: function that makes the classifier, see `classifier_maker`.
        scales: scale of each feature.
        X: shape (n, m), feature values of the examples.
        y: labels of the next states, n of them.
        names: names of the features, for errors.

    Raises:
        FeatureValueError: naming a feature whose value is impossible or missing.
        TrainingError: if the classifier cannot learn from these examples.
    """
    check_scales(scales, names)
    values = feature_values(X, scales, names)
    data = [str(spec), [asdict(scale) for scale in scales], values.tolist(), list(y)]
    digest = hashlib.sha256(json.dumps(data).encode()).hexdigest()
    if len(set(y)) == 1:
        return ClassifierFunction(str(spec), HandWritten(lambda: y[0]), digest)
    encoding = encoding_of(values, scales)
    try:
        classifier = make().fit(encoding(values), np.asarray(y))
        classifier.predict(encoding(values))  # some fail only here, e.g. with too few neighbors
    except Exception as error:  # whatever it raises, the user has to fix it
        raise TrainingError(
            f'"{spec}" cannot learn from {quantity(len(values), "example")}: {error}; '
            "give more examples, other parameters, or use the tree"
        ) from error

    def predict(*row: float) -> str:
        return str(classifier.predict(encoding(feature_values([row], scales, names)))[0])

    return ClassifierFunction(str(spec), HandWritten(predict, tuple(range(len(scales)))), digest)
