"""Any scikit-learn classifier in place of the tree.

It is named by a text such as ``sklearn.neighbors.KNeighborsClassifier(n_neighbors=1)``, which is
parsed, never run: a class of scikit-learn, and keywords with literal values. scikit-learn is
imported when the first such function is learned, so agents that use trees do not need it. A
decision takes one prediction of the classifier, usually a thousand times as long as a tree's.

A missing value is refused by name. It is not filled in: a made-up value would be learned like a
demonstrated one, and nobody would see it.
"""

from __future__ import annotations

import hashlib
import inspect
import json
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hitab_core.arrays import Floats
from hitab_core.domain import Scale
from hitab_core.errors import TrainingError, VocabularyError
from hitab_core.learning.classifier_spec import ClassifierSpec
from hitab_core.learning.feature_encoding import FeatureEncoding
from hitab_core.learning.feature_values import check_scales, feature_values
from hitab_core.transition_function import Decide, Explanation, Values
from hitab_core.vocabulary import has
from hitab_core.wording import quantity


def classifier_maker(spec: ClassifierSpec) -> Callable[[], Any]:
    """Return a function that makes a new, unfitted classifier.

    ``random_state`` defaults to 0 where the classifier has one, so that the same examples give the
    same function.

    Raises:
        VocabularyError: if there is no such class in scikit-learn, or it cannot be made.
    """
    made = _class_called(spec.name)
    arguments = dict(spec.arguments)
    if "random_state" in inspect.signature(made).parameters:
        arguments.setdefault("random_state", 0)
    try:
        made(**arguments)
    except TypeError as error:
        raise VocabularyError(f'"{spec}" cannot be made: {error}') from error
    return lambda: made(**arguments)


def _class_called(name: str) -> type:
    """Return a public classifier of scikit-learn; nothing else is imported or made."""
    module, _, attribute = name.rpartition(".")
    why = ""
    if module.split(".")[0] == "sklearn" and "._" not in name:
        try:
            from sklearn.base import ClassifierMixin  # here, so that trees do without it

            made = getattr(import_module(module), attribute, None)
            if isinstance(made, type) and issubclass(made, ClassifierMixin):
                return made
        except ImportError as error:
            why = f" ({error})"
    raise VocabularyError(
        f'"{name}" is not a classifier of scikit-learn{why}; write "tree", or its import path, '
        "such as sklearn.neighbors.KNeighborsClassifier"
    )


@dataclass(frozen=True)
class ClassifierFunction:
    """A transition function that a scikit-learn classifier has learned.

    Attributes:
        spec: the classifier, as text.
        labels: the next states seen, sorted.
        classifier: fitted; its classes are the indices of ``labels``. None if there is only one.
        encoding: of the feature values for it.
        data_digest: SHA-256 of the spec and the training data.
    """

    spec: str
    labels: tuple[str, ...]
    classifier: Any
    encoding: FeatureEncoding
    data_digest: str

    @property
    def features_used(self) -> tuple[int, ...]:
        """All features; none if there is only one next state."""
        return tuple(range(len(self.encoding.scales))) if self.classifier is not None else ()

    def predict_proba(self, X: ArrayLike) -> Floats:
        """Return the probability of each next state.

        If the classifier gives no probabilities, what it predicts has probability 1.

        Args:
            X: shape (n, m), feature values.

        Returns:
            shape (n, n_labels), in the order of ``labels``.

        Raises:
            FeatureValueError: naming a feature whose value is impossible or missing.
        """
        values = feature_values(X, self.encoding.scales)
        if self.classifier is None:
            return np.ones((len(values), 1))
        encoded = self.encoding(values)
        if hasattr(self.classifier, "predict_proba"):
            odds: Floats = np.asarray(self.classifier.predict_proba(encoded), np.float64)
            return odds
        predicted = np.asarray(self.classifier.predict(encoded))
        certain: Floats = (predicted[:, None] == np.arange(len(self.labels))).astype(np.float64)
        return certain

    def compile(
        self, slots: Sequence[int], states: Mapping[str, int], *, most_probable: bool = False
    ) -> Decide:
        """Return the decision as a function; see `TransitionFunction.compile`.

        States are drawn in the order of their indices, with one draw per uncertain decision. Among
        equally probable states ``most_probable`` takes the lowest index.

        Raises:
            VocabularyError: if it leads to a state that is not in ``states``.
        """
        for label in self.labels:
            if label not in states:
                raise VocabularyError(
                    f'examples lead to "{label}", which is not a state {has(states)}'
                )
        order = sorted(range(len(self.labels)), key=lambda i: states[self.labels[i]])
        choices = [states[self.labels[i]] for i in order]
        used = [slots[f] for f in self.features_used]
        if not used and len(choices) == 1:
            only = choices[0]
            return lambda values, read, draw: only

        def decide(values: Values, read: Callable[[int], float], draw: Callable[[], float]) -> int:
            row = [v if (v := values[slot]) is not None else read(slot) for slot in used]
            odds = self.predict_proba([row])[0][order]
            if most_probable or odds.max() == 1.0:
                return choices[int(odds.argmax())]
            cumulative = odds.cumsum()
            # The sum may miss 1 by rounding, and a draw above it would choose nothing.
            return choices[bisect_right(cumulative[:-1].tolist(), draw())]

        return decide

    def explain(self, values: Sequence[float], names: Sequence[str]) -> Explanation:
        """Explain the decision for a full feature vector: only the classifier's name."""
        odds = self.predict_proba([values])[0].tolist()
        likely = {label: p for label, p in zip(self.labels, odds, strict=True) if p > 0}
        return Explanation((self.spec,), self.features_used, likely)

    def retrace(self, values: Sequence[float | None], names: Sequence[str]) -> Explanation:
        """Explain a past decision without predicting again: without probabilities."""
        read = tuple(i for i in self.features_used if values[i] is not None)
        likely = dict.fromkeys(self.labels, 1.0) if self.classifier is None else {}
        return Explanation((self.spec,), read, likely)

    def digest(self) -> str:
        """Return a SHA-256, in hexadecimal, of the spec and the training data.

        A tree's digest is of the learned tree instead; a classifier's internals are private.
        """
        return self.data_digest


def learn_replacement(
    spec: ClassifierSpec,
    make: Callable[[], Any],
    scales: Sequence[Scale],
    X: ArrayLike,
    y: Sequence[str],
    names: Sequence[str] | None = None,
) -> ClassifierFunction:
    """Learn a transition function with a scikit-learn classifier.

    Args:
        spec: which classifier.
        make: makes the classifier, see `classifier_maker`.
        scales: how the values of each feature compare.
        X: shape (n, m), feature values of the examples.
        y: labels of the next states, n of them.
        names: names of the features, for errors.

    Raises:
        FeatureValueError: naming a feature whose value is impossible or missing.
        TrainingError: if the classifier cannot learn from these examples.
    """
    check_scales(scales, names)
    values = feature_values(X, scales, names)
    encoding = FeatureEncoding.of(values, scales)
    labels, classes = np.unique(np.asarray(y, dtype=str), return_inverse=True)
    learned_from = json.dumps(
        [
            str(spec),
            [asdict(scale) for scale in scales],
            [[v.hex() for v in row] for row in values.tolist()],
            list(y),
        ]
    )
    classifier = make() if len(labels) > 1 else None
    function = ClassifierFunction(
        str(spec),
        tuple(labels.tolist()),
        classifier,
        encoding,
        hashlib.sha256(learned_from.encode()).hexdigest(),
    )
    if classifier is not None:
        try:
            classifier.fit(encoding(values), classes)
            function.predict_proba(values)  # some fail only here, e.g. with too few neighbors
        except Exception as error:  # whatever it raises, the user has to fix it
            raise TrainingError(
                f'"{spec}" cannot learn from {quantity(len(values), "example")}: {error}; '
                "give more examples, other parameters, or use the tree"
            ) from error
    return function
