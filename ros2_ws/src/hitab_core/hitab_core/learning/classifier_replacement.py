"""Any scikit-learn classifier in place of the tree.

It is named by a text such as ``sklearn.neighbors.KNeighborsClassifier(n_neighbors=1)``, which is
parsed, never run: a class that scikit-learn lists among its classifiers, and keywords with literal
values. scikit-learn is imported when the first such function is learned, so agents that use trees
do not need it. A decision takes one prediction of the classifier, usually a thousand times as long
as a tree's.

A missing value is given to a classifier that says it takes NaN (scikit-learn's tag ``allow_nan``).
Any other refuses it by name. It is not filled in: a made-up value would be learned like a
demonstrated one, and nobody would see it.
"""

from __future__ import annotations

import hashlib
import inspect
import json
import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hitab_core.arrays import Floats
from hitab_core.domain import Scale
from hitab_core.errors import NoValueError, TrainingError, VocabularyError
from hitab_core.learning.classifier_spec import ClassifierSpec
from hitab_core.learning.feature_encoding import FeatureEncoding
from hitab_core.learning.feature_values import check_scales, feature_values
from hitab_core.transition_function import Decide, Explanation, Values
from hitab_core.vocabulary import has
from hitab_core.wording import quantity

_REMEMBERED = 64
"""How many recent predictions a function keeps, so that explaining one needs no prediction."""


def classifier_maker(spec: ClassifierSpec) -> Callable[[], Any]:
    """Return a function that makes a new, unfitted classifier.

    ``random_state`` defaults to 0 where the classifier has one, so that the same examples give the
    same function.

    Raises:
        VocabularyError: if scikit-learn does not list the class, or the class lacks a keyword.
    """
    try:
        listed = _listed()
    except ImportError as error:
        raise VocabularyError(
            f'"{spec}" needs scikit-learn, which is not installed; install it or use "tree"'
        ) from error
    if spec.name not in listed:
        raise VocabularyError(
            f'"{spec.name}" is not a classifier of scikit-learn '
            f"{has(['tree', *listed], spec.name)}"
        )
    made = listed[spec.name]
    known = sorted(inspect.signature(made).parameters)
    for name in spec.arguments:
        if name not in known:
            raise VocabularyError(f'"{spec.name}" has no parameter "{name}" {has(known, name)}')
    arguments = dict(spec.arguments)
    if "random_state" in known:
        arguments.setdefault("random_state", 0)
    try:
        made(**arguments)
    except TypeError as error:
        raise VocabularyError(f'"{spec}" cannot be made: {error}') from error
    return lambda: made(**arguments)


@cache
def _listed() -> Mapping[str, type]:
    """Return scikit-learn's classifiers by name; this imports all its modules."""
    from sklearn.utils import all_estimators  # here, so that trees do without it

    return {_public_name(made): made for _, made in all_estimators(type_filter="classifier")}


def _public_name(made: type) -> str:
    """Return a class's import path, leaving out private modules."""
    path: list[str] = []
    for part in made.__module__.split("."):
        if part.startswith("_"):
            break
        path.append(part)
    return ".".join([*path, made.__name__])


@dataclass(frozen=True)
class ClassifierFunction:
    """A transition function that a scikit-learn classifier has learned.

    Attributes:
        spec: the classifier, as text.
        labels: the next states seen, sorted.
        classifier: fitted; its classes are the indices of ``labels``. None if there is only one.
        encoding: of the feature values for it.
        takes_nan: whether it decides where a value is missing.
        data_digest: SHA-256 of the spec and the training data.
    """

    spec: str
    labels: tuple[str, ...]
    classifier: Any
    encoding: FeatureEncoding
    takes_nan: bool
    data_digest: str
    _recent: dict[tuple[float, ...], list[float]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

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
            FeatureValueError: naming a feature whose value is impossible, or missing if it takes
                no NaN.
        """
        values = feature_values(X, self.encoding.scales, may_miss=self.takes_nan)
        if self.classifier is None:
            return np.ones((len(values), 1))
        encoded = self.encoding(values)
        if hasattr(self.classifier, "predict_proba"):
            found: Floats = np.asarray(self.classifier.predict_proba(encoded), np.float64)
            totals: Floats = found.sum(axis=1, keepdims=True)
            if np.isfinite(totals).all() and (totals > 0).all():
                odds: Floats = found / totals
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
        takes_nan = self.takes_nan
        if not used and len(choices) == 1:
            only = choices[0]
            return lambda values, read, draw: only

        def decide(values: Values, read: Callable[[int], float], draw: Callable[[], float]) -> int:
            row = []
            for slot in used:
                value = values[slot]
                try:
                    row.append(read(slot) if value is None else value)
                except NoValueError:
                    if not takes_nan:
                        raise
                    row.append(math.nan)
            odds = np.array(self._odds(row))[order]
            if most_probable or odds.max() == 1.0:
                return choices[int(odds.argmax())]
            cumulative = odds.cumsum()
            # The sum may miss 1 by rounding, and a draw above it would choose nothing.
            return choices[bisect_right(cumulative[:-1].tolist(), draw())]

        return decide

    def explain(self, values: Sequence[float], names: Sequence[str]) -> Explanation:
        """Explain the decision for a full feature vector: only the classifier's name."""
        feature_values(
            [values],
            self.encoding.scales,
            names,
            ["the values to explain"],
            may_miss=self.takes_nan,
        )
        odds = self.predict_proba([values])[0].tolist()
        likely = {label: p for label, p in zip(self.labels, odds, strict=True) if p > 0}
        return Explanation((self.spec,), self.features_used, likely)

    def retrace(self, values: Sequence[float | None], names: Sequence[str]) -> Explanation:
        """Explain a past decision without predicting again."""
        read = tuple(i for i in self.features_used if values[i] is not None)
        if self.classifier is None:
            return Explanation((self.spec,), read, dict.fromkeys(self.labels, 1.0))
        seen = (v for i in read if (v := values[i]) is not None)
        odds = self._recent.get(tuple(math.nan if v != v else v for v in seen), ())
        likely = {label: p for label, p in zip(self.labels, odds, strict=False) if p > 0}
        return Explanation((self.spec,), read, likely)

    def _odds(self, row: Sequence[float]) -> list[float]:
        """Return the probability of each next state; cache recent ones."""
        key, recent = tuple(row), self._recent
        odds = recent.get(key)
        if odds is None:
            odds = self.predict_proba([row])[0].tolist()
            while len(recent) >= _REMEMBERED:
                del recent[next(iter(recent))]
            recent[key] = odds
        return odds

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
        FeatureValueError: naming a feature whose value is impossible, or missing if the classifier
            takes no NaN.
        TrainingError: if the classifier cannot learn from these examples.
    """
    check_scales(scales, names)
    classifier = make()
    may_miss = takes_nan(classifier)
    values = feature_values(X, scales, names, may_miss=may_miss)
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
    if len(labels) < 2:
        classifier = None
    function = ClassifierFunction(
        str(spec),
        tuple(labels.tolist()),
        classifier,
        encoding,
        may_miss,
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


def takes_nan(classifier: Any) -> bool:
    """Return whether a classifier of scikit-learn learns and decides where values are missing."""
    from sklearn.utils import get_tags  # here, so that trees do without it

    return bool(get_tags(classifier).input_tags.allow_nan)
