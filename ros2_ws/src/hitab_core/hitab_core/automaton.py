"""Automata as they are learned and stored: the tuple ⟨S, B, F, T, G⟩ of the paper, frozen.

`hitab_core.running.running_automaton` is one being performed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from hitab_core.errors import VocabularyError
from hitab_core.example import Example
from hitab_core.term import Term
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
"""The features that each automaton has of its own, whatever the domain: whether its active state's
behavior has raised a flag, and timers, in simulated seconds. ``SecondsInState`` counts from the
entry into the active state, and is 0 in Start, which is left at once. ``SecondsSince(Done)``
counts from the last time that the automaton saw this flag up, or, if it never did, from its start.
"""

CLEARED = frozenset({*map(Term, FLAGS), Term(SECONDS_IN_STATE)})
"""Flags and timers that are 0 when a state is entered."""

OWN_NAMES = frozenset(term.name for term in OWN_FEATURES)


def as_entered(
    features: Iterable[Term], values: Iterable[float], seconds: float = 0.0
) -> tuple[float, ...]:
    """Return values as a state sees them so many seconds after it was entered, with no flag up.

    Args:
        features: of an automaton.
        values: theirs, in the state that was left.
        seconds: since the entry.
    """
    own = dict.fromkeys(CLEARED, 0.0) | {Term(SECONDS_IN_STATE): seconds}
    return tuple(own.get(term, value) for term, value in zip(features, values, strict=True))


@dataclass(frozen=True)
class Automaton:
    """A learned or hand-written hierarchical finite-state automaton.

    Attributes:
        name: of the automaton, also as a behavior.
        states: S without Start: flags, and terms of basic behaviors or other automata (B).
        features: F, in the order of the examples' values; a flag's name is the feature that the
            active sub-behavior has raised that flag.
        transitions: T, a transition function for each state that has one, by label, Start
            included. In a state without one the automaton stays.
        parameters: G, the free variables, bound by the user of the automaton.
        examples: what the transition functions were learned from; none for a hand-written one.
        readable: names of the examples' readings.
        chosen: the features that were chosen for its training, if some of them were trimmed.
        numbers: what gives the numbers of each state whose behavior takes some, by label. Without
            it, such a behavior does nothing.

    Raises:
        VocabularyError: if it has a state twice or a transition function for none of its states.

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
        """Check what does not depend on the behaviors used."""
        labels = tuple(str(state) for state in self.states)
        there: set[str] = set()
        for label in labels:
            if label in there:
                raise VocabularyError(f'automaton "{self.name}" has state "{label}" twice')
            there.add(label)
        if START in there:
            raise VocabularyError(
                f'automaton "{self.name}": {START} is implicit; remove it from the states'
            )
        for state in self.transitions:
            if state != START and state not in there:
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
        """The states' labels, without Start."""
        return self._labels

    @property
    def behaviors_used(self) -> frozenset[str]:
        """Names of the behaviors that its states perform."""
        return frozenset(state.name for state in self.states if state.name not in FLAGS)
