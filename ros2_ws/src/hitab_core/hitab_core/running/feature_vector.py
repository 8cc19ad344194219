"""The feature vector of one automaton: features of the domain, and its own flags and timers.

Flags are raised by the behavior of the active state; a query clears them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from hitab_core.automaton import FLAGS, OWN_NAMES
from hitab_core.running.feature_cache import value_or_nan
from hitab_core.running.run_context import RunContext, Running
from hitab_core.term import Term
from hitab_core.texts.errors import NoValueError


class FeatureVector:
    """The features of an automaton being performed, each read when a decision needs it.

    Args:
        context: context of the agent.
        bindings: bindings of the automaton's parameters to targets.
        features: features of the automaton, in its own terms.

    Attributes:
        features: features of the automaton, in its own terms.
        bindings: bindings of the automaton's parameters to targets.
        slots: slots of the features, in the agent's `FeatureCache`.
        values, read_one: values of that cache by slot, and its `FeatureCache.read`.
        entered: time of the entry into the active state, s.
        has_own: whether `query` has anything to do: flags, timers or required features.
    """

    def __init__(
        self, context: RunContext, bindings: Mapping[str, str], features: Sequence[Term]
    ) -> None:
        self.bindings = dict(bindings)
        self._clock = context.clock
        self._cache = context.feature_cache
        self._domain = context.repertoire.domain
        self.values = self._cache.values
        self.read_one = self._cache.read
        self.start()
        self.choose(features)

    def choose(self, features: Sequence[Term]) -> None:
        """Replace the features."""
        self.features = tuple(features)
        self.slots: list[int] = []
        self._flags: list[tuple[int, str]] = []
        self._timers: list[tuple[int, str]] = []
        self._required: list[int] = []
        for feature in features:
            if feature.name in FLAGS:
                slot = self._cache.own_slot()
                self._flags.append((slot, feature.name))
            elif feature.name in OWN_NAMES:
                slot = self._cache.own_slot()
                self._timers.append((slot, "".join(feature.arguments)))
            else:
                slot = self._cache.slot(feature.bound(self.bindings))
                if self._domain.features[feature.name].required:
                    self._required.append(slot)
            self.slots.append(slot)
        self.has_own = bool(self._flags or self._timers or self._required)

    def start(self) -> None:
        """Set all timers to now."""
        self._clock.changes += 1
        self.entered = now = self._clock.now
        self._seen = dict.fromkeys(FLAGS, now)

    def enter(self) -> None:
        """Reset the timer of the active state."""
        self._clock.changes += 1
        self.entered = self._clock.now

    def memento(self) -> tuple[float, dict[str, float]]:
        """Return the timers, to restore them later."""
        return self.entered, dict(self._seen)

    def restore(self, memento: tuple[float, dict[str, float]]) -> None:
        """Restore the timers."""
        self._clock.changes += 1
        self.entered, self._seen = memento[0], dict(memento[1])

    def query(self, child: Running | None) -> None:
        """Fill in flags and timers for a transition function; clear the flags.

        Args:
            child: behavior of the active state.

        Raises:
            FeatureValueError: if a required feature has no value.
        """
        self.check_required()
        raised = child.raised if child is not None else None
        for slot, flag in self._flags:
            self.values[slot] = 1.0 if raised and flag in raised else 0.0
        for slot, flag in self._timers:
            self.values[slot] = self._seconds_since(flag, child)
        if raised:
            self.take_down(raised)

    def take_down(self, raised: set[str]) -> None:
        """Clear flags; their timers count from now."""
        self._clock.changes += bool(raised)
        for flag in raised:
            self._seen[flag] = self._clock.now
        raised.clear()

    def check_required(self) -> None:
        """Check that all required features have values.

        Raises:
            FeatureValueError: if one has none.
        """
        for slot in self._required:
            self.read_one(slot)

    def known(self) -> list[float | None]:
        """Return the values that were read in this tick; see `FeatureCache.known`."""
        return list(map(self._cache.known, self.slots))

    def read(self) -> list[float]:
        """Return the values of all features; NaN if one is missing.

        Raises:
            FeatureValueError: if a required feature has no value.
        """
        return list(map(self._value_or_nan, self.slots))

    def _value_or_nan(self, slot: int) -> float:
        try:
            return self.read_one(slot)
        except NoValueError:
            return math.nan

    def peek(self, child: Running | None) -> list[float]:
        """Return the values that the next query would see, without clearing flags."""
        self.preset(child)
        return self.read()

    def preset(self, child: Running | None) -> None:
        """Fill in flags and timers as the next query would, without clearing flags."""
        for slot, flag in self._flags:
            self.values[slot] = self._is_up(flag, child)
        for slot, flag in self._timers:
            self.values[slot] = self._seconds_since(flag, child)

    def look(self, feature: Term, child: Running | None) -> float:
        """Return the value of any feature, in the automaton's terms, or NaN; change nothing."""
        if feature.name not in OWN_NAMES:
            return value_or_nan(self._cache.look, feature.bound(self.bindings))
        if feature.name in FLAGS:
            return self._is_up(feature.name, child)
        return self._seconds_since("".join(feature.arguments), child)

    def _is_up(self, flag: str, child: Running | None) -> float:
        return float(child is not None and flag in child.raised)

    def _seconds_since(self, flag: str, child: Running | None) -> float:
        """Return the seconds since a flag was seen up; for "", since the state was entered."""
        now = self._clock.now
        if flag:
            up = child is not None and flag in child.raised
            since = now if up else self._seen[flag]
        else:
            since = now if child is None else self.entered
        return max(0.0, now - since)
