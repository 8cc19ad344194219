"""An automaton being performed: the paper's step, one timestep after the other.

    a percept              body.sense(values)
        |
        v
    f_t, the features      FeatureVector: each is read when the decision needs it
        |
        v
    T(S_t, f_t)            decide: the transition function of the active state S_t
        |
        v
    S_t+1 = S_t? --no----> _enter: stop the behavior of S_t, start that of S_t+1
        |                     |
        v                     v
    one pulse              child.tick(): a basic behavior; for an automaton, this same step
        |
        v
    an action              body.act()

Source: the paper, section 3, "Running HiTAB".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from hitab_core.action_behavior import ActionBehavior
from hitab_core.automaton import FLAGS, START, Automaton
from hitab_core.domain import BasicBehavior
from hitab_core.running.feature_vector import FeatureVector
from hitab_core.running.given_numbers import GivenNumbers
from hitab_core.running.observing import Change
from hitab_core.running.run_context import RunContext, Running
from hitab_core.running.running_basic import (
    RunningAction,
    RunningBasicBehavior,
    RunningWithNumbers,
)
from hitab_core.term import Term
from hitab_core.transition_function import Decide, NumberFunction, TransitionFunction


def performance(
    context: RunContext, term: Term, parent: RunningAutomaton | None = None
) -> Running:
    """Return a behavior ready to start; all arguments must be targets."""
    behavior = context.repertoire.get(term.name)
    if isinstance(behavior, ActionBehavior):
        return RunningAction(context.repertoire.domain, context.body, behavior, term)
    if isinstance(behavior, BasicBehavior):
        kind = RunningWithNumbers if behavior.numbers else RunningBasicBehavior
        return kind(context.repertoire.domain, context.body, behavior, term)
    bindings = dict(zip(behavior.parameters, term.arguments, strict=True))
    return RunningAutomaton(context, behavior, bindings, parent, str(term))


class RunningAutomaton:
    """An automaton being performed: its active state and the child that performs this state.

    `tick` is the paper's step: query the transition function of the active state, change the state
    if necessary, pulse the active behavior. In training mode a demonstrator's `go_to` replaces the
    query, and `pulse` the tick.

    Attributes:
        context: the agent's repertoire, body and clock.
        automaton: the automaton, as learned and stored.
        bindings: parameters of the automaton, each with its target.
        label: label of the state that this automaton performs in its parent, or its name.
        path: labels of all automata from the outermost one to this.
        raised: raised flags, which the parent's next query reads and clears.
        vector: the feature vector.
    """

    def __init__(
        self,
        context: RunContext,
        automaton: Automaton,
        bindings: Mapping[str, str] | None = None,
        parent: RunningAutomaton | None = None,
        label: str = "",
    ) -> None:
        self.context = context
        self.automaton = automaton
        self.bindings = dict(bindings or {})
        self.label = label or automaton.name
        self.path: tuple[str, ...] = (*(parent.path if parent is not None else ()), self.label)
        self.raised: set[str] = set()
        self.vector = FeatureVector(context, self.bindings, automaton.features)
        # A state is an index into these lists; Start is 0.
        self._labels: list[str] = [START]
        self._index: dict[str, int] = {START: 0}
        self._children: list[Running | None] = [None]
        self._decide: list[Decide | None] = [None]
        self._active = 0
        for state in automaton.states:
            self.add_state(state)
        self._numbers = GivenNumbers(context.number_range)
        self.set_transitions(automaton.transitions, automaton.numbers)

    @property
    def active(self) -> str:
        """Label of the active state."""
        return self._labels[self._active]

    @property
    def child(self) -> Running | None:
        """Behavior of the active state; None in Start and in flag states."""
        return self._children[self._active]

    @property
    def function(self) -> TransitionFunction | None:
        """Transition function of the active state; None if it has none."""
        return self._functions.get(self.active)

    @property
    def active_path(self) -> list[str]:
        """Labels of the active states, from this automaton inwards."""
        child = self.child
        inner = child.active_path if isinstance(child, RunningAutomaton) else []
        return [self.active, *inner]

    def start(self) -> None:
        """Begin in Start, with no flag raised."""
        self._active = 0
        self.vector.start()
        self.raised.clear()

    def stop(self) -> None:
        """Stop the active states, innermost first, and return to Start."""
        child = self._children[self._active]
        if child is not None:
            child.stop()
        self.context.clock.changes += 1
        self._active = 0

    def memento(self) -> tuple[Any, ...]:
        """Return the active state, timers, flags and the same of the child; see `Running`."""
        inner = None if self.child is None else self.child.memento()
        return self.active, self.vector.memento(), frozenset(self.raised), inner

    def restore(self, memento: Any) -> None:
        """Be in the states of a memento; see `Running`."""
        label, timers, raised, inner = memento
        index, child = self._index.get(label, 0), self.child
        if index != self._active:
            if child is not None:
                child.stop()
            self._active = index
            child = self.child
            if child is not None:
                child.start()
        self.vector.restore(timers)
        self.raised.clear()
        self.raised.update(raised)
        if child is not None and inner is not None:
            child.restore(inner)

    def upcoming(
        self, draw: Callable[[], float], *, entered: bool
    ) -> tuple[str, str, Running | None]:
        """Return the active state, the one that the next tick would choose, and its behavior.

        Args:
            draw: function that gives random numbers.
            entered: whether this automaton would be started before.
        """
        active = 0 if entered or self.child is None else self._active
        child, decide = self._children[active], self._decide[active]
        chosen = active
        if decide is not None:
            self.vector.preset(child)
            chosen = decide(self.vector.values, self.vector.read_one, draw)
        return self._labels[active], self._labels[chosen], self._children[chosen]

    def tick(self) -> None:
        """Query, change state if the transition function says so, and pulse.

        Raises:
            FeatureValueError: if a required feature has no value, even if no test reads it.
        """
        active = self._active  # S_t
        child = self._children[active]
        if child is None and active:
            self.context.clock.changes += 1
            active = self._active = 0  # a flag state returns to Start, which is left at once
        vector = self.vector
        if vector.has_own:
            vector.query(child)  # flags and timers; other features are read when a test needs them
        decide = self._decide[active]
        if decide is not None:  # otherwise no example leaves this state
            chosen = decide(vector.values, vector.read_one, self.context.draw)  # S_t+1
            if chosen != active:
                child = self._enter(chosen)
        if self._numbers.functions:
            self._numbers.give(self.label, self.active, child, vector.read)
        if child is not None:
            child.tick()

    def _enter(self, index: int, *, commanded: bool = False) -> Running | None:
        """Stop the behavior of the active state and start the behavior of another one."""
        observe = self.context.observe
        if observe is not None:
            vector, source, to = self.vector, self._labels[self._active], self._labels[index]
            if commanded:
                observe(Change(self.path, source, to, True))
            else:
                decision = vector.features, vector.bindings, vector.known()
                function = self._functions.get(source)
                observe(Change(self.path, source, to, False, *decision, function))
        old = self._children[self._active]
        if old is not None:
            old.stop()
        self._active = index
        self.vector.enter()
        child = self._children[index]
        if child is not None:
            child.start()
        elif index:
            self.raised.add(self._labels[index])
        return child

    def pulse(self) -> None:
        """Perform one timestep of the active state without a query: a demonstrator decides."""
        child = self._children[self._active]
        if child is not None:
            child.tick()
        elif self._active:
            self.context.clock.changes += 1
            self._active = 0  # a flag was raised; the flag state is left at once

    def go_to(self, label: str) -> None:
        """Change to a state on a demonstrator's command; do nothing if it is active."""
        index = self._index[label]
        if index != self._active:
            self._enter(index, commanded=True)

    def add_state(self, state: Term) -> None:
        """Add a state unless it exists, as when a behavior is commanded for the first time."""
        label = str(state)
        if label in self._index:
            return
        child: Running | None = None
        if state.name not in FLAGS:
            child = performance(self.context, state.bound(self.bindings), self)
        self._index[label] = len(self._labels)
        self._labels.append(label)
        self._children.append(child)
        self._decide.append(None)

    def set_transitions(
        self,
        transitions: Mapping[str, TransitionFunction],
        numbers: Mapping[str, NumberFunction] | None = None,
    ) -> None:
        """Replace the transition functions, and the functions for numbers; keep the state."""
        self._numbers.functions = dict(numbers or {})
        self._functions = dict(transitions)
        self._decide = [None] * len(self._labels)
        for label, function in transitions.items():
            self._decide[self._index[label]] = function.compile(
                self.vector.slots, self._index, most_probable=self.context.most_probable
            )

    def set_features(self, features: Sequence[Term]) -> None:
        """Replace the features; the caller must then set transition functions that use them."""
        self.automaton = replace(self.automaton, features=tuple(features), transitions={})
        self.vector.choose(features)
        self.set_transitions({})

    def set_numbers(self, numbers: tuple[float, ...]) -> None:
        """Give numbers to the behavior of the active state, if it takes any."""
        child = self.child
        if isinstance(child, RunningWithNumbers):
            self.context.clock.changes += 1
            child.give(numbers)

    def take_down_flags(self) -> None:
        """Clear the flags of the active behavior, since a command replaces the query."""
        if self.child is not None:
            self.vector.take_down(self.child.raised)

    def look(self, feature: Term) -> float:
        """Return the present value of a feature, or NaN, without clearing flags."""
        return self.vector.look(feature, self.child)
