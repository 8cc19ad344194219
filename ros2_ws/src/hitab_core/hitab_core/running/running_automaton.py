"""An automaton, or a basic behavior, being performed by one agent."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

from hitab_core.action_behavior import ActionBehavior
from hitab_core.automaton import FLAGS, OWN_NAMES, START, Automaton
from hitab_core.domain import BasicBehavior
from hitab_core.errors import NoValueError
from hitab_core.repertoire import Repertoire
from hitab_core.running.feature_cache import FeatureCache, value_or_nan
from hitab_core.running.observing import Change, Observe, guest
from hitab_core.running.running_basic import (
    RunningAction,
    RunningBasicBehavior,
    RunningWithNumbers,
)
from hitab_core.transition_function import Decide, NumberFunction, TransitionFunction
from hitab_core.use import Use


class Running(Protocol):
    """A behavior being performed."""

    @property
    def raised(self) -> set[str]:
        """The raised flags that are still up."""

    @property
    def active_path(self) -> list[str]:
        """Labels of the active states, outermost first; none in a basic behavior."""

    def start(self) -> None:
        """Start performing from the beginning."""

    def tick(self) -> None:
        """Perform one timestep."""

    def stop(self) -> None:
        """Stop performing, innermost first."""


@dataclass(slots=True)
class Clock:
    """The simulated time of an agent's last percept, s; set together with the percept."""

    now: float = 0.0


@dataclass(slots=True)
class NumberRange:
    """Range around the shown moments in which numbers are taken from them.

    Attributes:
        max_distance: in usual differences; farther off, a state that takes numbers does nothing.
        reason: why such a state did nothing in this tick, or empty.
    """

    max_distance: float = math.inf
    reason: str = ""


@dataclass(frozen=True, slots=True)
class RunContext:
    """The context shared by everything that one agent performs.

    Attributes:
        repertoire: the available behaviors.
        body: of this agent, made by the domain.
        feature_cache: its features, read from this body.
        draw: uniform random numbers on [0, 1) from the agent's own seeded generator.
        most_probable: take the most probable next state instead of drawing one.
        observe: called at each change of state, after the decision and before the new state
            starts. Its exceptions do not propagate; see `hitab_core.running.observing`.
        clock: for the timers of its automata.
        number_range: how far from the moments shown there are numbers.
    """

    repertoire: Repertoire
    body: Any
    feature_cache: FeatureCache
    draw: Callable[[], float]
    most_probable: bool = False
    observe: Observe | None = None
    clock: Clock = field(default_factory=Clock)
    number_range: NumberRange = field(default_factory=NumberRange)

    def __post_init__(self) -> None:
        """Wrap the observer so that its exceptions do not propagate."""
        if self.observe is not None:
            object.__setattr__(self, "observe", guest(self.observe))

    def perform(self, use: Use, above: RunningAutomaton | None = None) -> Running:
        """Return a performance of ``use``, not started; all arguments must be targets."""
        behavior = self.repertoire.get(use.name)
        if isinstance(behavior, ActionBehavior):
            return RunningAction(self.repertoire.domain, self.body, behavior, use)
        if isinstance(behavior, BasicBehavior) and behavior.numbers:
            return RunningWithNumbers(self.repertoire.domain, self.body, behavior, use)
        if isinstance(behavior, BasicBehavior):
            return RunningBasicBehavior(self.repertoire.domain, self.body, behavior, use)
        bindings = dict(zip(behavior.parameters, use.arguments, strict=True))
        return RunningAutomaton(self, behavior, bindings, above, str(use))


class RunningAutomaton:
    """An automaton being performed: its active state and, inside it, what that performs.

    `tick` is the paper's step: query the transition function of the active state, change state if
    it says so, pulse the active behavior. When a demonstrator is in control, `go_to` and `pulse`
    replace the query.
    """

    def __init__(
        self,
        context: RunContext,
        automaton: Automaton,
        bindings: Mapping[str, str] | None = None,
        above: RunningAutomaton | None = None,
        label: str = "",
    ) -> None:
        self.context = context
        self.automaton = automaton
        self.bindings = dict(bindings or {})
        self.above = above
        self.label = label or automaton.name
        self.path: tuple[str, ...] = (*(above.path if above is not None else ()), self.label)
        self.raised: set[str] = set()
        self._clock = context.clock
        self._entered = self._clock.now
        self._seen = dict.fromkeys(FLAGS, self._clock.now)
        self._feature_cache = context.feature_cache
        self._values = context.feature_cache.values
        self._read = context.feature_cache.read
        self._labels: list[str] = [START]
        self._children: list[Running | None] = [None]
        self._decide: list[Decide | None] = [None]
        self._functions: dict[str, TransitionFunction] = {}
        self._index: dict[str, int] = {START: 0}
        self._numbers: dict[int, NumberFunction] = {}
        self._active = 0
        for state in automaton.states:
            self.add_state(state)
        self._slots: list[int] = []
        self._flag_slots: list[tuple[int, str]] = []
        self._timer_slots: list[tuple[int, str]] = []
        self._required: list[int] = []
        self._bind(automaton.features)
        self.set_transitions(automaton.transitions, automaton.numbers)

    def _bind(self, features: Sequence[Use]) -> None:
        """Find the slots of the features."""
        self._slots, self._flag_slots, self._timer_slots, self._required = [], [], [], []
        for feature in features:
            if feature.name in FLAGS:
                slot = self._feature_cache.own_slot()
                self._flag_slots.append((slot, feature.name))
            elif feature.name in OWN_NAMES:
                slot = self._feature_cache.own_slot()
                self._timer_slots.append((slot, "".join(feature.arguments)))
            else:
                slot = self._feature_cache.slot(feature.bound(self.bindings))
                if self.context.repertoire.domain.features[feature.name].required:
                    self._required.append(slot)
            self._slots.append(slot)
        self._looks_first = bool(self._flag_slots or self._timer_slots or self._required)

    def set_features(self, features: Sequence[Use]) -> None:
        """Use other features; transition functions must follow."""
        self.automaton = replace(self.automaton, features=tuple(features), transitions={})
        self._bind(features)
        self.set_transitions({})

    def add_state(self, state: Use) -> None:
        """Add a state, as training does when a behavior is first commanded."""
        label = str(state)
        if label in self._index:
            return
        child: Running | None = None
        if state.name not in FLAGS:
            child = self.context.perform(state.bound(self.bindings), self)
        self._index[label] = len(self._labels)
        self._labels.append(label)
        self._children.append(child)
        self._decide.append(None)

    def set_transitions(
        self,
        transitions: Mapping[str, TransitionFunction],
        numbers: Mapping[str, NumberFunction] | None = None,
    ) -> None:
        """Use these functions from now on; keep the active state."""
        self._numbers = {self._index[label]: give for label, give in (numbers or {}).items()}
        self._functions = dict(transitions)
        self._decide = [None] * len(self._labels)
        for label, function in transitions.items():
            self._decide[self._index[label]] = function.compile(
                self._slots, self._index, most_probable=self.context.most_probable
            )

    @property
    def active(self) -> str:
        """The label of the active state."""
        return self._labels[self._active]

    @property
    def function(self) -> TransitionFunction | None:
        """The transition function of the active state; None if it has none."""
        return self._functions.get(self.active)

    @property
    def numbers(self) -> NumberFunction | None:
        """Number function of the active state, or None."""
        return self._numbers.get(self._active)

    @property
    def child(self) -> Running | None:
        """Behavior of the active state; None in Start and in flag states."""
        return self._children[self._active]

    @property
    def active_path(self) -> list[str]:
        """The active states, from this automaton inwards."""
        child = self.child
        inner = child.active_path if isinstance(child, RunningAutomaton) else []
        return [self.active, *inner]

    def start(self) -> None:
        """Begin in Start, with no flag raised."""
        self._active = 0
        self._entered = now = self._clock.now
        self._seen = dict.fromkeys(FLAGS, now)
        self.raised.clear()

    def stop(self) -> None:
        """Stop the active states, innermost first, and return to Start."""
        child = self._children[self._active]
        if child is not None:
            child.stop()
        self._active = 0

    def tick(self) -> None:
        """Query, change state if the transition function says so, and pulse.

        Raises:
            FeatureValueError: if a required feature has no value, in whatever state.
        """
        active = self._active
        child = self._children[active]
        if child is None:
            active = self._active = 0  # Start and flag states are left at once
        if self._looks_first:
            self._look_first(child)
        decide = self._decide[active]
        if decide is not None:
            chosen = decide(self._values, self._read, self.context.draw)
            if chosen != active:
                child = self._enter(chosen)
        if self._numbers and (give := self.numbers) is not None:
            values = [self._value_or_nan(slot) for slot in self._slots]
            if self._is_in_reach(give, values):
                self.set_numbers(give(values))
        if child is not None:
            child.tick()

    def check_required(self) -> None:
        """Check that all required features have values.

        Raises:
            FeatureValueError: if one has none.
        """
        for slot in self._required:
            self._read(slot)

    def pulse(self) -> None:
        """Perform one timestep of the active state without a query: a demonstrator decides."""
        child = self._children[self._active]
        if child is not None:
            child.tick()
        else:
            self._active = 0  # a flag was raised; the flag state is left at once

    def go_to(self, label: str) -> None:
        """Change to a state on a demonstrator's command; do not restart the active state."""
        index = self._index[label]
        if index != self._active:
            self._enter(index, commanded=True)

    def set_numbers(self, numbers: tuple[float, ...]) -> None:
        """Perform the active state with these numbers, if its behavior takes any."""
        child = self.child
        if isinstance(child, RunningWithNumbers):
            child.give(numbers)

    def _is_in_reach(self, give: NumberFunction, values: Sequence[float]) -> bool:
        """Return whether to take numbers from the moments shown; halt what takes them if not."""
        number_range, child = self.context.number_range, self.child
        if (
            number_range.max_distance == math.inf
            or (away := give.distance(values)) <= number_range.max_distance
        ):
            return True
        number_range.reason = (
            f"{self.label} in {self.active}: it is {away:.2g} spreads from the nearest moment "
            "whose numbers were shown"
        )
        if isinstance(child, RunningWithNumbers):
            child.halt()
        return False

    def entered_at(self, time: float) -> None:
        """Count the time in the active state from another time on, s."""
        self._entered = time

    def take_down_flags(self) -> None:
        """Lower the flags of the active state, since a demonstrator's command is the query."""
        child = self.child
        if child is not None and child.raised:
            self._see(child.raised)

    def peek_features(self) -> list[float]:
        """Return the current values of all features, NaN if one is missing; leave flags up.

        Raises:
            FeatureValueError: if a required feature has no value.
        """
        for slot, flag in self._flag_slots:
            self._values[slot] = self._own_feature(Use(flag))
        for slot, flag in self._timer_slots:
            self._values[slot] = self._seconds_since(flag)
        return [self._value_or_nan(slot) for slot in self._slots]

    def _value_or_nan(self, slot: int) -> float:
        try:
            return self._read(slot)
        except NoValueError:
            return math.nan

    def look(self, feature: Use) -> float:
        """Return the current value of a feature in its own terms, or NaN; change nothing."""
        if feature.name in OWN_NAMES:
            return self._own_feature(feature)
        return value_or_nan(self._feature_cache.look, feature.bound(self.bindings))

    def _own_feature(self, use: Use) -> float:
        """Return the current value of a flag or timer; leave flags up."""
        if use.name not in FLAGS:
            return self._seconds_since("".join(use.arguments))
        child = self.child
        return float(child is not None and use.name in child.raised)

    def _seconds_since(self, flag: str) -> float:
        """Return the seconds since a flag was seen up; for "", since the state was entered."""
        child, now = self.child, self._clock.now
        if flag:
            up = child is not None and flag in child.raised
            since = now if up else self._seen[flag]
        else:
            since = now if child is None else self._entered
        return max(0.0, now - since)

    def _look_first(self, child: Running | None) -> None:
        """Check what is required and fill in flags and timers; a flag that was seen goes down."""
        self.check_required()
        raised = child.raised if child is not None else None
        for slot, flag in self._flag_slots:
            self._values[slot] = 1.0 if raised and flag in raised else 0.0
        for slot, flag in self._timer_slots:
            self._values[slot] = self._seconds_since(flag)
        if raised:
            self._see(raised)

    def _see(self, raised: set[str]) -> None:
        for flag in raised:
            self._seen[flag] = self._clock.now
        raised.clear()

    def _enter(self, index: int, *, commanded: bool = False) -> Running | None:
        observe = self.context.observe
        if observe is not None:
            observe(self._change(index, commanded))
        old = self._children[self._active]
        if old is not None:
            old.stop()
        self._active = index
        self._entered = self._clock.now
        child = self._children[index]
        if child is None:
            if index:
                self.raised.add(self._labels[index])
        else:
            child.start()
        return child

    def _change(self, index: int, commanded: bool) -> Change:
        source, destination = self._labels[self._active], self._labels[index]
        if commanded:
            return Change(self.path, source, destination, True)
        return Change(
            self.path,
            source,
            destination,
            False,
            self.automaton.features,
            self.bindings,
            [self._feature_cache.known(slot) for slot in self._slots],
            self._functions.get(source),
        )
