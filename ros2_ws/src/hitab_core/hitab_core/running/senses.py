"""The features of one agent, each read at most once per tick and only when a decision needs it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any, ParamSpec

from hitab_core.domain import Domain, FeatureKind
from hitab_core.errors import FeatureValueError, HitabError, VocabularyError
from hitab_core.transition_function import Values
from hitab_core.use import Use

P = ParamSpec("P")

BLIND = "nothing perceived yet; let the world run, or wait for the robot's sensors"


def resolved(function: Callable[..., Any], body: Any, domain: Domain, use: Use) -> Any:
    """Return ``function`` bound to the body and to ``use``'s targets, resolved at each call."""
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
    """Feature values by slot, shared by all automata of an agent.

    ``values[slot]`` is None until :meth:`read` is called in this tick. So a decision reads only
    the features that it needs, and each feature is read once however many levels use it.

    Attributes:
        values: of the features, by slot.
        perceived: whether there was a percept yet.
    """

    __slots__ = ("_blank", "_body", "_domain", "_readers", "_slots", "perceived", "values")

    def __init__(self, body: Any, domain: Domain) -> None:
        self.values: Values = []
        self.perceived = False
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
        """Return a new slot that the automaton fills itself."""
        return self._new(None)

    def _new(self, reader: Callable[[], float] | None) -> int:
        self._readers.append(reader)
        self._blank.append(None)
        self.values.append(None)
        return len(self._readers) - 1

    def read(self, slot: int) -> float:
        """Return the value in ``slot``, reading the feature on first use in this tick.

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
        """Return a feature's value for an observer, without caching it.

        A value already read by a decision is returned as it is. Any other is read now, and a later
        decision reads it again.

        Raises:
            FeatureValueError: if the feature's value is missing or not a number.
        """
        slot = self._slots.get(use)
        value = None if slot is None else self.values[slot]
        return self._reader(use)() if value is None else value

    def forget(self) -> None:
        """Clear all values, for a new percept."""
        self.perceived = True
        self.values[:] = self._blank

    def check_perceived(self) -> None:
        """Check that there was a percept.

        Raises:
            FeatureValueError: if there was none: all values would be those of an empty body.
        """
        if not self.perceived:
            raise FeatureValueError(BLIND)

    @contextmanager
    def blind_unless_perceived(self) -> Iterator[None]:
        """Explain what a domain's code raises when it looks for a percept that never came.

        Raises:
            FeatureValueError: instead of any error but a `HitabError`, before the first percept.
        """
        try:
            yield
        except HitabError:
            raise
        except Exception as error:
            if self.perceived:
                raise
            raise FeatureValueError(f"{BLIND} ({error!r})") from error


def value_or_nan(read: Callable[P, float], *args: P.args, **kwargs: P.kwargs) -> float:
    """Return a value, such as a feature's; NaN if it is missing or cannot be read."""
    try:
        return float(read(*args, **kwargs))
    except Exception:  # domain code
        return math.nan


def checked(read: Callable[[], float], name: str, categories: int) -> float:
    """Return a feature's value.

    Args:
        read: reads it.
        name: of the feature, for errors.
        categories: number of categories; 0 for a feature that is not categorical.

    Raises:
        FeatureValueError: if the value is missing, not a number or not a category.
    """
    read_value: Any = read()
    try:
        value = float(read_value)
    except (TypeError, ValueError, OverflowError):
        value = math.nan
    if value != value:
        raise FeatureValueError(
            f'feature "{name}" has no value (got {repr(read_value)[:50]}); check its sensor'
        )
    if categories and not (0 <= value < categories and value == int(value)):
        raise FeatureValueError(
            f'feature "{name}" has value {value:g}, not one of its {categories} categories'
        )
    return value
