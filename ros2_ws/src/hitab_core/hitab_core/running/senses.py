"""The features of one agent, each read at most once per tick and only when a decision needs it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, ParamSpec

from hitab_core.domain import Domain, FeatureKind
from hitab_core.errors import FeatureValueError, VocabularyError
from hitab_core.transition_function import Values
from hitab_core.use import Use

P = ParamSpec("P")


def resolved(function: Callable[..., Any], body: Any, domain: Domain, use: Use) -> Any:
    """Return ``function`` of the body and of ``use``'s targets as they are at each call."""
    for argument in use.arguments:
        if argument not in domain.targets:
            raise VocabularyError(f'"{argument}" in "{use}" is not bound to a target')
    resolvers = [domain.targets[argument].resolve for argument in use.arguments]
    if not resolvers:
        return partial(function, body)
    if len(resolvers) == 1:
        resolve = resolvers[0]
        return lambda: function(body, resolve(body))
    return lambda: function(body, *[resolve(body) for resolve in resolvers])


class Senses:
    """Feature values by slot. All automata that an agent runs share one of these.

    ``values[slot]`` is None until :meth:`read` was called in this tick, so that a decision costs
    only the features that it looks at, and looks at each once however many levels use it.
    """

    __slots__ = ("_blank", "_body", "_domain", "_readers", "_slots", "values")

    def __init__(self, body: Any, domain: Domain) -> None:
        self.values: Values = []
        self._blank: Values = []
        self._readers: list[Callable[[], float] | None] = []
        self._slots: dict[Use, int] = {}
        self._body = body
        self._domain = domain

    def slot(self, use: Use) -> int:
        """Return the slot of a feature bound to targets, making it on first use."""
        if use not in self._slots:
            self._slots[use] = self._new(self._reader(use))
        return self._slots[use]

    def _reader(self, use: Use) -> Callable[[], float]:
        feature = self._domain.features[use.name]
        return partial(
            checked,
            resolved(feature.read, self._body, self._domain, use),
            str(use),
            len(feature.categories) if feature.kind is FeatureKind.CATEGORICAL else 0,
        )

    def slot_for_flag(self) -> int:
        """Return a fresh slot that its automaton fills by itself."""
        return self._new(None)

    def _new(self, reader: Callable[[], float] | None) -> int:
        self._readers.append(reader)
        self._blank.append(None)
        self.values.append(None)
        return len(self._readers) - 1

    def read(self, slot: int) -> float:
        """Return the value in ``slot``, reading the feature if that was not done in this tick.

        Raises:
            FeatureValueError: if the feature's value is missing or not a number.
        """
        value = self.values[slot]
        if value is None:
            reader = self._readers[slot]
            value = 0.0 if reader is None else reader()
            self.values[slot] = value
        return value

    def look(self, use: Use) -> float:
        """Return a feature's value to somebody who asks beside the decisions; keep nothing.

        What a decision has read is returned as it was read. Anything else is read now, and the
        decision that needs it reads it for itself.

        Raises:
            FeatureValueError: if the feature's value is missing or not a number.
        """
        slot = self._slots.get(use)
        value = None if slot is None else self.values[slot]
        return self._reader(use)() if value is None else value

    def forget(self) -> None:
        """Forget all values: a new percept has come."""
        self.values[:] = self._blank


def value_or_nan(read: Callable[P, float], *args: P.args, **kwargs: P.kwargs) -> float:
    """Return a value, such as a feature's; NaN if it has none or cannot be read."""
    try:
        return float(read(*args, **kwargs))
    except Exception:  # of the domain's code
        return math.nan


def checked(read: Callable[[], float], name: str, categories: int) -> float:
    """Return a feature's value.

    Args:
        read: reads it.
        name: of the feature, for errors.
        categories: how many there are; 0 for a feature that is not categorical.

    Raises:
        FeatureValueError: if the value is missing, not a number or not a category.
    """
    value = read()
    if value is None or value != value:
        raise FeatureValueError(f'feature "{name}" has no value (got {value}); check its sensor')
    if categories and not (0 <= value < categories and value == int(value)):
        raise FeatureValueError(
            f'feature "{name}" has value {value}, not one of its {categories} categories'
        )
    return float(value)
