"""The tables of a learned behavior and all its parts, in a form that any language can hold.

Every automaton of the hierarchy occurs once for each binding of its parameters. Since a behavior
cannot use itself, each automaton is performed at most once at a time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NoReturn

from hitab_core import (
    FLAGS,
    OWN_FEATURES,
    START,
    ActionBehavior,
    Automaton,
    BoundedNumber,
    Repertoire,
    Term,
    TransitionFunction,
    TransitionTree,
    VocabularyError,
    in_order,
)
from hitab_core.learning import ClassifierFunction
from hitab_core.learning.compiled_tree import Compiled, Draw, compiled, leaf_choice
from hitab_core.regression import Neighbors, NumberTable
from hitab_core.running import checks_of

INTERNAL = tuple(map(str, OWN_FEATURES))
"""The features that each automaton has of its own; their indices precede those of the robot's."""


@dataclass(frozen=True, slots=True)
class TestForm:
    """A test ``low < value <= high``, after ``value %= period`` if the period is not 0.

    See `compiled_tree`.

    Attributes:
        feature: index into `INTERNAL` followed by `Hierarchy.features`.
        yes, no: index of the next node.
        share: fraction of the examples that went to ``yes``: its probability for a missing value.
    """

    feature: int
    period: float
    low: float
    high: float
    yes: int
    no: int
    share: float


@dataclass(frozen=True, slots=True)
class LeafForm:
    """Pairs of a number and a state's index: a state is drawn below its number; the last is 1."""

    chances: tuple[tuple[float, int], ...]


Tree = tuple[TestForm | LeafForm, ...]
"""A tree as a list of nodes: the root first, each node before its successors."""


@dataclass(frozen=True, slots=True)
class FeatureForm:
    """A feature bound to targets.

    Attributes:
        label: the feature's name with its targets.
        categories, required: as in `hitab_core.running.feature_cache.checked`.
        period: period of a toroidal feature, else 0.
        unit: unit of the values; empty if none.
    """

    label: str
    categories: int
    required: bool
    period: float
    unit: str


@dataclass(frozen=True, slots=True)
class NumbersForm:
    """The regression of a state's numbers, see `hitab_core.regression`.

    Attributes:
        features: indices as in `TestForm.feature`, one for each axis of the table.
        table: the learned numbers.
        wanted: the numbers.
    """

    features: tuple[int, ...]
    table: NumberTable
    wanted: tuple[BoundedNumber, ...]


@dataclass(frozen=True, slots=True)
class StateForm:
    """A state.

    Attributes:
        label: in the automaton's own terms.
        performs: a behavior bound to targets; None in Start and in flag states.
        is_automaton: whether that behavior is an automaton.
        one_shot: whether that behavior is pulsed only once.
        tree: decides on the next state; None if the state is never left.
        numbers: gives the numbers of the behavior; None if it takes none.
    """

    label: str
    performs: Term | None
    is_automaton: bool
    one_shot: bool
    tree: Tree | None
    numbers: NumbersForm | None = None


@dataclass(frozen=True, slots=True)
class AutomatonForm:
    """An automaton bound to targets; its first state is Start.

    Attributes:
        required: indices of the features without which it does nothing, whatever its state.
    """

    term: Term
    states: tuple[StateForm, ...]
    required: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Hierarchy:
    """The automata of a behavior, each after its parts; the last is the behavior itself."""

    automata: tuple[AutomatonForm, ...]
    features: tuple[FeatureForm, ...]

    @property
    def top(self) -> AutomatonForm:
        """The behavior itself."""
        return self.automata[-1]

    @property
    def basics(self) -> dict[Term, bool]:
        """The basic behaviors that the robot needs, and whether each is pulsed only once."""
        return {
            state.performs: state.one_shot
            for automaton in self.automata
            for state in automaton.states
            if state.performs is not None and not state.is_automaton
        }


def hierarchy_of(repertoire: Repertoire, term: Term) -> Hierarchy:
    """Return a behavior with all its parts.

    Args:
        repertoire: the robot's repertoire.
        term: a learned behavior, its parameters bound to targets.

    Raises:
        VocabularyError: if the behavior does not exist, or naming a part that cannot be exported.
    """
    repertoire.check_performable(term)
    if term.name not in repertoire.automata:
        raise VocabularyError(
            f'"{term.name}" is a basic behavior, which the robot has already; export a learned one'
        )

    def automata_of(label: str) -> list[str]:
        bound, parameters = _bound(repertoire, Term.parse(label))
        return [
            str(state.bound(parameters))
            for state in bound.states
            if state.name in repertoire.automata
        ]

    slots: dict[str, int] = {label: slot for slot, label in enumerate(INTERNAL)}
    forms = [
        _automaton(repertoire, Term.parse(label), slots)
        for label in in_order([str(term)], automata_of)
    ]
    features = []
    for label in list(slots)[len(INTERNAL) :]:
        feature = repertoire.domain.features[Term.parse(label).name]
        checks = checks_of(Term.parse(label), feature)
        features.append(FeatureForm(*checks, feature.scale.period, feature.unit))
    return Hierarchy(tuple(forms), tuple(features))


def _bound(repertoire: Repertoire, term: Term) -> tuple[Automaton, dict[str, str]]:
    automaton = repertoire.automata[term.name]
    return automaton, dict(zip(automaton.parameters, term.arguments, strict=True))


def _automaton(repertoire: Repertoire, term: Term, slots: dict[str, int]) -> AutomatonForm:
    automaton, parameters = _bound(repertoire, term)
    features = [str(feature.bound(parameters)) for feature in automaton.features]
    indices = {label: index for index, label in enumerate((START, *automaton.labels))}
    trees: dict[str, Tree] = {}
    for label, function in automaton.transitions.items():
        if not isinstance(function, TransitionTree):
            _refuse(term.name, function)
        for used in function.features_used:
            slots.setdefault(features[used], len(slots))
        trees[label] = _tree(function, [slots.get(name, -1) for name in features], indices)
    required = [
        slots.setdefault(label, len(slots)) - len(INTERNAL)
        for feature, label in zip(automaton.features, features, strict=True)
        if repertoire.domain.feature(feature.name).required
    ]
    states = [StateForm(START, None, False, False, trees.get(START))]
    for state, label in zip(automaton.states, automaton.labels, strict=True):
        if state.name in FLAGS:
            states.append(StateForm(label, None, False, False, None))
            continue
        if isinstance(repertoire.get(state.name), ActionBehavior):
            raise VocabularyError(
                f'"{term.name}" cannot be exported: "{state.name}" in it is an action, whose '
                "goals and results are handled by HiTAB; export a behavior that does without, "
                "or have HiTAB perform this one"
            )
        performs = state.bound(parameters)
        is_automaton, one_shot = state.name in repertoire.automata, repertoire.is_one_shot(state)
        numbers = _numbers(automaton, label, repertoire.domain.numbers_of(state), features, slots)
        tree = trees.get(label)
        states.append(StateForm(label, performs, is_automaton, one_shot, tree, numbers))
    return AutomatonForm(term, tuple(states), tuple(required))


def _numbers(
    automaton: Automaton,
    label: str,
    wanted: tuple[BoundedNumber, ...],
    features: list[str],
    slots: dict[str, int],
) -> NumbersForm | None:
    """Return the regression of a state's numbers."""
    if not wanted:
        return None
    learned = automaton.numbers.get(label)
    if not isinstance(learned, Neighbors):  # none was shown with any: it does nothing
        return NumbersForm((), NumberTable(), wanted)
    read = tuple(slots.setdefault(name, len(slots)) for name in features)
    return NumbersForm(read, learned.table, wanted)


def _refuse(name: str, function: TransitionFunction) -> NoReturn:
    if isinstance(function, ClassifierFunction):
        why = f"it was learned by {function.spec}, which is no tree; train it further as a tree"
    else:
        why = "it is written by hand, and code is not exported; train a behavior in its place"
    raise VocabularyError(f'automaton "{name}" cannot be exported: {why}')


def _tree(function: TransitionTree, slots: list[int], indices: dict[str, int]) -> Tree:
    states = [indices[label] for label in function.labels]
    queue: list[Compiled] = [
        compiled(function.root_, slots, lambda counts: leaf_choice(counts, states))
    ]
    nodes: list[TestForm | LeafForm] = []
    for node in queue:  # which grows
        if type(node) is tuple:
            slot, period, low, high, yes, no, share = node
            nodes.append(TestForm(slot, period, low, high, len(queue), len(queue) + 1, share))
            queue += [yes, no]
        elif isinstance(node, Draw):
            nodes.append(LeafForm(tuple(zip(node.cumulative, node.choices, strict=True))))
        else:
            nodes.append(LeafForm(((1.0, node),)))
    return tuple(nodes)
