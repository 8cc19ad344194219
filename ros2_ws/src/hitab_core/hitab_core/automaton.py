"""Automata as they are learned and stored: the tuple ⟨S, B, F, T, G⟩ of the paper, frozen.

`hitab_core.running.running_automaton.RunningAutomaton` performs one.

Source: the paper, section 3, "Formal Model".
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType

from hitab_core.example import Example
from hitab_core.term import Term
from hitab_core.texts.errors import VocabularyError
from hitab_core.transition_function import NumberFunction, TransitionFunction

START = "Start"
"""The empty state in which every automaton begins and which it leaves at once."""

FLAGS = ("Done", "Failed")
"""The flag states: entering one raises a flag in the parent automaton, then returns to Start."""

RESERVED_NAMES = frozenset((START, *FLAGS))

SECONDS_IN_STATE = "SecondsInState"
SECONDS_SINCE = "SecondsSince"

OWN_FEATURES = (
    *map(Term, FLAGS),
    Term(SECONDS_IN_STATE),
    *(Term(SECONDS_SINCE, (flag,)) for flag in FLAGS),
)
"""Features that every automaton has besides those of the domain: flags and timers.

A flag is 1 if the behavior of the active state has raised it since the last decision, otherwise
0. The timers are in simulated seconds. ``SecondsInState`` counts from the entry into the active
state, and is 0 in Start. ``SecondsSince(Done)`` counts from the last decision at which this flag
was raised, or from the start of the automaton if there was none.
"""

CLEARED = frozenset({*map(Term, FLAGS), Term(SECONDS_IN_STATE)})
"""Flags and timers that are reset to 0 when a state is entered."""

OWN_NAMES = frozenset(term.name for term in OWN_FEATURES)


def as_entered(
    features: Iterable[Term], values: Iterable[float], seconds: float = 0.0
) -> tuple[float, ...]:
    """Return feature values with flags and timers as they are after a new state is entered.

    Args:
        features: the features of an automaton.
        values: their values in the previous state.
        seconds: time since the new state was entered, s.
    """
    own = dict.fromkeys(CLEARED, 0.0) | {Term(SECONDS_IN_STATE): seconds}
    return tuple(own.get(term, value) for term, value in zip(features, values, strict=True))


@dataclass(frozen=True)
class Automaton:
    """A learned or hand-written hierarchical finite-state automaton.

    Attributes:
        name: name of the automaton, and of the behavior that performs it.
        states: S without Start: flag states, and basic behaviors or other automata (B), each a
            `Term`: a name with its arguments.
        features: F, in the order of the values of the examples.
        transitions: T, one transition function per state, by label; Start included. The automaton
            stays in a state that has none.
        parameters: G, the free variables, bound to targets where the automaton is used.
        examples: those that the transition functions were learned from; empty if hand-written.
        description: one sentence for people; may be empty.
        readable: features whose values the examples keep as ``readings``, in that order.
        chosen: features chosen for the training, if saving trimmed some of them.
        numbers: by label, the functions that compute the numbers of states whose behaviors take
            numbers, such as a speed. Such a behavior does nothing without its function.

    Raises:
        VocabularyError: if a state is listed twice, a transition function belongs to no state, or
            a name is reserved.

    Examples:
        >>> from hitab_core import HandWritten
        >>> patrol = Automaton(
        ...     "Patrol",
        ...     states=(Term("GoFast"), Term("Turn")),
        ...     features=(Term("RangeAhead"),),
        ...     transitions={
        ...         "Start": HandWritten(lambda: "GoFast"),
        ...         "GoFast": HandWritten(lambda ahead: "Turn" if ahead < 1.0 else "GoFast", (0,)),
        ...     },
        ... )
        >>> patrol.labels
        ('GoFast', 'Turn')
    """

    name: str
    states: tuple[Term, ...]
    features: tuple[Term, ...]
    transitions: Mapping[str, TransitionFunction]
    parameters: tuple[str, ...] = ()
    examples: tuple[Example, ...] = ()
    description: str = ""
    readable: tuple[Term, ...] = ()
    chosen: tuple[Term, ...] = ()
    numbers: Mapping[str, NumberFunction] = field(default_factory=dict, compare=False)
    _labels: tuple[str, ...] = field(init=False, repr=False, compare=False, default=())

    def __post_init__(self) -> None:
        """Check all but the existence of the behaviors, which the repertoire checks."""
        labels = tuple(str(state) for state in self.states)
        known: set[str] = set()
        for label in labels:
            if label in known:
                raise VocabularyError(f'automaton "{self.name}" has state "{label}" twice')
            known.add(label)
        if START in known:
            raise VocabularyError(
                f'automaton "{self.name}": {START} is implicit; remove it from the states'
            )
        for state in self.transitions:
            if state != START and state not in known:
                raise VocabularyError(
                    f'automaton "{self.name}" has a transition function for "{state}", '
                    "which is not one of its states"
                )
        for parameter in self.parameters:
            if parameter in RESERVED_NAMES:
                raise VocabularyError(
                    f'automaton "{self.name}": a parameter cannot be called "{parameter}", which '
                    "is reserved; rename it"
                )
        object.__setattr__(self, "_labels", labels)
        object.__setattr__(self, "transitions", MappingProxyType(dict(self.transitions)))

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the states, such as ``GotoBall(ball)``, without Start."""
        return self._labels

    @cached_property
    def feature_labels(self) -> tuple[str, ...]:
        """Labels of the features, such as ``DistanceTo(ball)``."""
        return tuple(map(str, self.features))

    @property
    def behaviors_used(self) -> frozenset[str]:
        """Names of the behaviors that the states perform."""
        return frozenset(state.name for state in self.states if state.name not in FLAGS)
