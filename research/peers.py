"""Other ways to learn from the same commands: what trained automata are compared with.

`learn` takes commands, each with what could be read in the situation, and returns a policy:

    policy = learn("nearest", commands, scales)
    policy(readings, state)         # the basic behavior to perform now

A peer knows one level, that of the basic behaviors. ``flat`` is an automaton with one state for
each, learned by the engine itself with its default examples. The others are behavior cloning:
they see what could be read and nothing else, neither the state nor what came before. They can be
used with commands from lessons, or with those of a demonstrator who takes over (`takeovers`).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from hitab_core import START, Automaton, Example, ExampleKind, HandWritten, Scale, Term
from hitab_core.learning import learn_transitions
from hitab_core.learning.feature_encoding import encoding_of
from hitab_core.numeric.arrays import Floats
from hitab_core.transition_function import TransitionFunction


class Command(NamedTuple):
    """What a demonstrator's command says to a peer.

    Attributes:
        readings: values of all features in the situation; NaN: nothing to be read.
        state: the basic behavior performed until then, or ``"Start"``.
        behavior: the basic behavior to perform from then on.
    """

    readings: tuple[float, ...]
    state: str
    behavior: str


@dataclass(frozen=True)
class Policy:
    """What a peer has learned.

    Attributes:
        behaviors: that it can choose.
        transitions: its decision in each state; the same one in all states if it knows no states.
        examples: that it was learned from, with default ones.
        knows_states: whether its decisions depend on the state.
    """

    behaviors: tuple[str, ...]
    transitions: Mapping[str, TransitionFunction]
    examples: int
    knows_states: bool

    def __call__(self, readings: Sequence[float], state: str) -> str:
        """Return the behavior to perform now; the state itself where nothing was learned of it."""
        known = state if self.knows_states else START
        function = self.transitions.get(known)
        if function is None:
            return state
        found = function.explain(readings, [""] * len(readings)).distribution
        return max(found, key=lambda label: found[label])

    def automaton(
        self, name: str, features: Sequence[Term], parameters: tuple[str, ...] = ()
    ) -> Automaton:
        """Return it as an automaton, which the engine performs like any other."""
        states = tuple(Term.parse(behavior) for behavior in self.behaviors)
        return Automaton(name, states, tuple(features), self.transitions, parameters)


ITERATIONS = 500  # of the perceptron's training, at most

Options = Mapping[str, Any]
Choose = Callable[[Floats], int]
"""Returns the index of the class of one encoded row."""

OPTIONS: Mapping[str, tuple[Options, ...]] = {
    "flat": ({},),
    "nearest": ({"n_neighbors": 1}, {"n_neighbors": 3}),
    "tree": ({}, {"max_depth": 3}),
    "mlp": (
        {"hidden_layer_sizes": (32,), "alpha": 1e-2},
        {"hidden_layer_sizes": (32, 32), "alpha": 1.0},
    ),
}
"""The peers, and the settings of each that are worth trying."""

TITLES: Mapping[str, str] = {
    "flat": "one flat automaton",
    "nearest": "nearest neighbors",
    "tree": "scikit-learn's decision tree",
    "mlp": "multi-layer perceptron",
}


def learn(
    name: str,
    commands: Sequence[Command],
    scales: Sequence[Scale],
    *,
    one_shot: Collection[str] = (),
    limits: Sequence[float] | None = None,
    options: Options | None = None,
) -> Policy:
    """Learn from commands.

    Args:
        name: of a peer, see `OPTIONS`.
        commands: at least one.
        scales: how the values of each feature compare.
        one_shot: the behaviors that get no default example.
        limits: largest value of each feature that makes a difference, so that a value such as
            1000 for "never" does not make all others equal; None: no limits.
        options: settings of the learner; None: the first ones in `OPTIONS`.

    Raises:
        ValueError: if there is no such peer, or no command.
    """
    if name not in OPTIONS:
        raise ValueError(f'there is no peer "{name}"; there are {", ".join(OPTIONS)}')
    if not commands:
        raise ValueError("a peer needs at least one command; give some before it learns")
    chosen = OPTIONS[name][0] if options is None else options
    behaviors = tuple(dict.fromkeys(command.behavior for command in commands))
    if name == "flat":
        return _flat(commands, scales, behaviors, one_shot)
    return _cloned(name, commands, scales, behaviors, limits, chosen)


def _flat(
    commands: Sequence[Command],
    scales: Sequence[Scale],
    behaviors: tuple[str, ...],
    one_shot: Collection[str],
) -> Policy:
    known = {START, *behaviors}
    examples: list[Example] = []
    for number, (readings, state, behavior) in enumerate(commands, 1):
        before = state if state in known else START
        examples.append(Example(before, readings, behavior, command=number))
        if behavior != before and behavior not in one_shot:
            default = Example(behavior, readings, behavior, ExampleKind.DEFAULT, command=number)
            examples.append(default)
    return Policy(behaviors, learn_transitions(examples, scales), len(examples), True)


def _cloned(
    name: str,
    commands: Sequence[Command],
    scales: Sequence[Scale],
    behaviors: tuple[str, ...],
    limits: Sequence[float] | None,
    options: Options,
) -> Policy:
    largest = np.array(limits if limits is not None else [np.inf] * len(scales))
    X = np.minimum(np.array([c.readings for c in commands], dtype=np.float64), largest)
    missing = np.where(np.isnan(X).all(axis=0), 0.0, np.nanmean(_some(X), axis=0))
    X = np.where(np.isnan(X), missing, X)
    encoding = encoding_of(X, scales)
    y = np.array([behaviors.index(command.behavior) for command in commands])
    choose = _LEARNERS[name](encoding(X), y, dict(options))

    def decide(*readings: float) -> str:
        row = np.minimum(np.array([readings]), largest)
        return behaviors[choose(encoding(np.where(np.isnan(row), missing, row)))]

    function = HandWritten(decide, tuple(range(len(scales))))
    return Policy(behaviors, dict.fromkeys((START, *behaviors), function), len(commands), False)


def _some(X: Floats) -> Floats:
    """Return values with a zero where a whole column is missing."""
    return np.where(np.isnan(X).all(axis=0), 0.0, X)


# Each learner is scikit-learn's. One row is classified here, since scikit-learn's checks of its
# input take a hundred times as long as the decision; the tests compare the two.


def _nearest(X: Floats, y: np.ndarray, options: dict[str, Any]) -> Choose:
    count = min(options.pop("n_neighbors"), len(X))
    classes = int(y.max()) + 1

    def choose(row: Floats) -> int:
        near = np.argsort(((X - row) ** 2).sum(axis=1), kind="stable")[:count]
        return int(np.bincount(y[near], minlength=classes).argmax())

    return choose


def _tree(X: Floats, y: np.ndarray, options: dict[str, Any]) -> Choose:
    from sklearn.tree import DecisionTreeClassifier

    tree = DecisionTreeClassifier(random_state=0, **options).fit(X, y)
    leaves = tree.classes_[tree.tree_.value[:, 0, :].argmax(axis=1)]
    apply = tree.tree_.apply
    return lambda row: int(leaves[apply(row.astype(np.float32))[0]])


def _perceptron(X: Floats, y: np.ndarray, options: dict[str, Any]) -> Choose:
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.neural_network import MLPClassifier

    if len(set(y)) == 1:
        only = int(y[0])
        return lambda row: only
    net = MLPClassifier(solver="lbfgs", max_iter=ITERATIONS, random_state=0, **options)
    with warnings.catch_warnings():
        # Commands that contradict each other cannot be fitted, however long it tries.
        warnings.simplefilter("ignore", ConvergenceWarning)
        net.fit(X, y)
    weights, biases = net.coefs_, net.intercepts_

    def choose(row: Floats) -> int:
        for weight, bias in zip(weights[:-1], biases[:-1], strict=True):
            row = np.maximum(row @ weight + bias, 0.0)
        out = (row @ weights[-1] + biases[-1])[0]
        return int(net.classes_[out.argmax() if len(out) > 1 else int(out[0] > 0.0)])

    return choose


_LEARNERS: Mapping[str, Callable[[Floats, np.ndarray, dict[str, Any]], Choose]] = {
    "nearest": _nearest,
    "tree": _tree,
    "mlp": _perceptron,
}


@dataclass(frozen=True)
class Learner:
    """A peer with everything that it needs to learn from commands.

    Attributes:
        name: of the peer.
        settings: keyword arguments of `learn`.
    """

    name: str
    settings: Mapping[str, Any]

    @property
    def knows_states(self) -> bool:
        """Whether what it learns depends on the state."""
        return self.name == "flat"

    def __call__(self, commands: Sequence[Command]) -> Policy:
        """Learn from commands."""
        return learn(self.name, commands, **self.settings)
