"""The features of one agent, each read at most once per tick and only when a decision needs it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import Any, ParamSpec

from hitab_core.domain import Domain, Feature, FeatureKind
from hitab_core.term import Term
from hitab_core.texts.errors import FeatureValueError, HitabError, NoValueError, VocabularyError
from hitab_core.transition_function import Values

P = ParamSpec("P")

ON_CIRCLE = -1
"""In place of a number of categories: the feature is toroidal."""

NO_PERCEPT_YET = "nothing perceived yet; let the world run, or wait for the robot's sensors"


def resolved(function: Callable[..., Any], body: Any, domain: Domain, term: Term) -> Any:
    """Return ``function`` bound to the body and to the term's targets, resolved at each call."""
    for argument in term.arguments:
        if argument not in domain.targets:
            raise VocabularyError(f'"{argument}" in "{term}" is not bound to a target')
    resolvers = [domain.targets[argument].resolve for argument in term.arguments]
    if not resolvers:
        return partial(function, body)
    if len(resolvers) == 1:
        resolve = resolvers[0]
        return lambda: function(body, resolve(body))
    return lambda: function(body, *[resolve(body) for resolve in resolvers])


class FeatureCache:
    """Feature values by slot, shared by all automata of an agent.

    ``values[slot]`` is None until :meth:`read` is called in this tick. So a decision reads only
    the features in use, and each feature is read once however many levels use it.

    Attributes:
        values: values of the features, by slot.
        perceived: whether there was a percept yet.
        failed: exceptions of the domain's code in reading features; None before the first look.
        missed: why a feature that a decision needed had no value, by feature; see `lacking`.
    """

    def __init__(self, body: Any, domain: Domain) -> None:
        self.values: Values = []
        self.perceived = False
        self.missed: dict[Term, str] = {}
        self.failed: dict[Term, Exception] | None = None
        self._missing: dict[int, NoValueError] = {}
        self._blank: Values = []
        self._readers: list[Callable[[], float]] = []
        self._slots: dict[Term, int] = {}
        self._made: dict[Term, Callable[[], float]] = {}
        self._body = body
        self._domain = domain

    def slot(self, term: Term) -> int:
        """Return the slot of a feature bound to targets, making it on first use."""
        if term not in self._slots:
            self._slots[term] = self._new(self._reader(term))
        return self._slots[term]

    def _reader(self, term: Term) -> Callable[[], float]:
        reader = self._made.get(term)
        if reader is None:
            feature = self._domain.features[term.name]
            read = resolved(feature.read, self._body, self._domain, term)
            reader = self._made[term] = partial(checked, read, *checks_of(term, feature))
        return reader

    def own_slot(self) -> int:
        """Return a new slot that the automaton fills itself."""
        return self._new(float)

    def _new(self, reader: Callable[[], float]) -> int:
        self._readers.append(reader)
        self._blank.append(None)
        self.values.append(None)
        return len(self._readers) - 1

    def read(self, slot: int) -> float:
        """Return the value in ``slot``, reading the feature on first use in this tick.

        Raises:
            NoValueError: if the feature has no value now.
            FeatureValueError: if it has none and no decision may do without.
        """
        value = self.values[slot]
        if value is None:
            if self._missing and slot in self._missing:
                raise self._missing[slot].with_traceback(None)
            try:
                value = self._readers[slot]()
            except NoValueError as error:
                self._missing[slot] = error
                self.missed[self._term_of(slot)] = str(error)
                raise
            self.values[slot] = value
        return value

    def _term_of(self, slot: int) -> Term:
        return next(term for term, at in self._slots.items() if at == slot)

    def known(self, slot: int) -> float | None:
        """Return a value that was read in this tick; NaN if it was missing, None if not read."""
        return math.nan if slot in self._missing else self.values[slot]

    def lacking(self) -> list[str]:
        """Return why features that decisions needed still have no value.

        A feature is listed from the first decision that had to do without until it has a value
        again, whether decisions still need it or not.
        """
        if not self.missed:
            return []
        for term in list(self.missed):
            try:
                self.look(term)
            except NoValueError as error:
                self.missed[term] = str(error)
            except Exception:  # domain code: a decision on the feature will report it
                pass
            else:
                del self.missed[term]
        return list(self.missed.values())

    def look(self, term: Term) -> float:
        """Return a feature's value for an observer, without caching it.

        A value already read by a decision is returned as it is. Any other is read now, and a later
        decision reads it again.

        Raises:
            FeatureValueError: if the feature's value is missing or not a number.
        """
        slot = self._slots.get(term)
        value = None if slot is None else self.values[slot]
        try:
            return self._reader(term)() if value is None else value
        except FeatureValueError:
            raise
        except Exception as error:
            # The distance of a target from itself is of no use.
            if self.failed is not None and len({*term.arguments}) == len(term.arguments):
                self.failed[term] = error
            raise

    def failing(self) -> Mapping[Term, Exception]:
        """Return the exceptions of the domain's code in reading features.

        The first percept reads each feature; later ones read the failed ones, used or not.
        """
        if not self.perceived or (self.failed is not None and not self.failed):
            return {}
        terms = _one_of_each(self._domain) if self.failed is None else self.failed
        self.failed = {}
        for term in terms:
            value_or_nan(self.look, term)
        return self.failed

    def forget(self) -> None:
        """Clear all values, for a new percept."""
        self.perceived = True
        self.values[:] = self._blank
        if self._missing:
            self._missing.clear()

    @contextmanager
    def blind_unless_perceived(self) -> Iterator[None]:
        """Explain an exception of domain code that expects a percept before the first one.

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
            raise FeatureValueError(f"{NO_PERCEPT_YET} ({error!r})") from error


def _one_of_each(domain: Domain) -> Iterator[Term]:
    """Yield each feature with each target once, not with all combinations of targets."""
    targets = sorted(domain.targets)
    for feature in domain.features.values():
        wanted = len(feature.parameters)
        for first in range(len(targets) if wanted else 1):
            yield Term(feature.name, tuple((targets * wanted)[first : first + wanted]))


def value_or_nan(read: Callable[P, float], *args: P.args, **kwargs: P.kwargs) -> float:
    """Return a value, such as a feature's; NaN if it is missing or cannot be read."""
    try:
        return float(read(*args, **kwargs))
    except Exception:  # domain code
        return math.nan


def checked(read: Callable[[], float], name: str, categories: int, required: bool) -> float:
    """Return a feature's value.

    Args:
        read: function that reads the feature.
        name: name of the feature with its targets, for errors.
        categories: number of categories; `ON_CIRCLE` for a toroidal feature, 0 for any other.
        required: see `Feature.required`.

    Raises:
        NoValueError: if there is no value: NaN, no number, or ``read`` raises it.
        FeatureValueError: if the value is impossible, missing but required, or if ``read`` raises
            it.
    """
    try:
        read_value: Any = read()
    except NoValueError as error:
        if required:
            raise FeatureValueError(str(error)) from error
        raise
    try:
        value = float(read_value)
    except (TypeError, ValueError, OverflowError):
        value = math.nan
    if value != value:
        got = "" if isinstance(read_value, float) else f" (got {repr(read_value)[:50]})"
        why = f'feature "{name}" has no value{got}; check its sensor'
        raise FeatureValueError(why) if required else NoValueError(why)
    if categories:
        _check_possible(value, name, categories)
    return value


def _check_possible(value: float, name: str, categories: int) -> None:
    if categories == ON_CIRCLE:
        if math.isinf(value):
            raise FeatureValueError(f'feature "{name}" has value {value}, not on its circle')
    elif not (0 <= value < categories and value == int(value)):
        raise FeatureValueError(
            f'feature "{name}" has value {value:g}, not one of its {categories} categories'
        )


def checks_of(term: Term, feature: Feature) -> tuple[str, int, bool]:
    """Return the arguments of `checked` for a feature bound to targets."""
    categories = len(feature.categories) if feature.kind is FeatureKind.CATEGORICAL else 0
    if feature.kind is FeatureKind.TOROIDAL:
        categories = ON_CIRCLE
    return str(term), categories, feature.required
