"""Learned behaviors of an agent, from its topics and its service `get_behavior`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any

from hitab_msgs.msg import Question

from hitab_core import (
    START,
    Automaton,
    BoundedNumber,
    Example,
    FeatureKind,
    Remark,
    Scale,
    Term,
    TransitionTree,
    with_numbers,
)
from hitab_core.assistant import TrainingCost
from hitab_core.learning import Arc, Categories, Fork, Leaf, Node, Test, Threshold
from hitab_core.regression import Neighbors, learn_numbers
from hitab_ros.conversions import cost_of, example_of, numbers_of_behaviors, remarks_of

NO_TREES: Mapping[str, TransitionTree] = MappingProxyType({})


@dataclass(frozen=True)
class Learned:
    """One automaton of an agent.

    Attributes:
        origin: "basic", "hand-written", "trained" or "training".
        parameters, arguments: parameters, and their targets during training.
        states: labels of the states; in training, of the chosen or commanded ones.
        chosen: labels of the states chosen when the training began; empty if any state can be
            commanded, or without a training.
        features: labels of the features, in the order of the examples' values.
        units, scales: units and scales of the features.
        examples: all examples.
        trees: transition trees, by state.
        readable: names of the readings in the examples.
        with_numbers: numbers of the behaviors that take numbers, by name.
    """

    name: str
    origin: str
    description: str
    classifier: str
    parameters: tuple[str, ...]
    arguments: tuple[str, ...]
    states: tuple[str, ...]
    features: tuple[str, ...]
    units: tuple[str, ...]
    scales: tuple[Scale, ...]
    examples: tuple[Example, ...]
    trees: Mapping[str, TransitionTree] = field(default_factory=lambda: NO_TREES)
    readable: tuple[str, ...] = ()
    version: int = 0
    versions: tuple[int, ...] = ()
    created: str = ""
    note: str = ""
    difference: str = ""
    trimmed: tuple[str, ...] = ()
    chosen: tuple[str, ...] = ()
    with_numbers: Mapping[str, tuple[BoundedNumber, ...]] = field(default_factory=dict)

    @property
    def is_automaton(self) -> bool:
        """Whether this is an automaton, not a basic behavior."""
        return self.origin != "basic"

    @cached_property
    def automaton(self) -> Automaton | None:
        """The automaton with its trees; None without trees."""
        if not self.trees:
            return None
        labels = dict.fromkeys(
            s for e in self.examples for s in (e.state, e.next_state) if s != START
        )
        return Automaton(
            self.name,
            tuple(map(Term.parse, labels)),
            tuple(map(Term.parse, self.features)),
            self.trees,
            self.parameters,
            self.examples,
            self.description,
        )

    def numbers_of(self, state: Term) -> tuple[BoundedNumber, ...]:
        """Return the numbers that a state's behavior takes."""
        return self.with_numbers.get(state.name, ())

    def commanded(self, example: Example) -> str:
        """Return an example's next state with its numbers, as ``RunTowards(direction=40)``."""
        state = Term.parse(example.next_state)
        return str(with_numbers(state, example.numbers, self.numbers_of(state)))

    @cached_property
    def numbers(self) -> Mapping[str, Neighbors]:
        """Number functions of the states that take numbers, by label."""
        states = map(Term.parse, self.states)
        return learn_numbers(states, self.scales, self.examples, self.numbers_of)

    def decides(self, state: str, values: Sequence[float]) -> Mapping[str, float]:
        """Return the probability of each next state; empty if unknown."""
        tree = self.trees.get(state)
        if tree is None or any(math.isnan(v) for v in values):
            return {}
        return tree.explain(values, self.features).distribution


@dataclass(frozen=True)
class Training(Learned):
    """Training of an agent, as published.

    Attributes:
        revision: number that increases with each change.
        done, undone: changes that undo and redo would affect, in words, oldest first.
        searched: whether the search for questions is complete, and the cost is known.
        questions: open questions.
        answered: answered questions with their answers, oldest first.
        remarks: signs that the behavior does not work.
        cost: cost of the training so far; None if unknown.
    """

    revision: int = 0
    done: tuple[str, ...] = ()
    undone: tuple[str, ...] = ()
    searched: bool = False
    questions: tuple[Question, ...] = ()
    answered: tuple[str, ...] = ()
    remarks: tuple[Remark, ...] = ()
    cost: TrainingCost | None = None


def learned_of(answer: Any) -> Learned:
    """Return the content of an answer of `GetBehavior`."""
    return Learned(
        **_fields(answer.automaton),
        origin=answer.origin,
        version=answer.version,
        versions=tuple(answer.versions),
        created=answer.created,
        note=answer.note,
        difference=answer.difference,
        trimmed=tuple(answer.trimmed),
    )


def training_of(message: Any) -> Training:
    """Return the content of a message about a training."""
    return Training(
        **_fields(message.automaton),
        origin="training",
        revision=message.revision,
        done=tuple(message.done),
        undone=tuple(message.undone),
        searched=message.searched,
        questions=tuple(message.questions),
        answered=tuple(message.answered),
        remarks=remarks_of(message.remarks),
        cost=cost_of(message.cost) if message.cost.automaton else None,
    )


def _fields(message: Any) -> dict[str, Any]:
    scales = tuple(
        Scale(FeatureKind(f.kind), f.period, tuple(f.categories)) for f in message.features
    )
    return {
        "name": message.name,
        "description": message.description,
        "classifier": message.classifier,
        "parameters": tuple(message.parameters),
        "arguments": tuple(message.arguments),
        "states": tuple(message.states),
        "chosen": tuple(message.chosen_states),
        "features": tuple(f.name for f in message.features),
        "units": tuple(f.unit for f in message.features),
        "scales": scales,
        "readable": tuple(message.readable),
        "with_numbers": numbers_of_behaviors(message.with_numbers),
        "examples": tuple(map(example_of, message.examples)),
        "trees": MappingProxyType({tree.state: _tree(tree, scales) for tree in message.trees}),
    }


def _tree(message: Any, scales: tuple[Scale, ...]) -> TransitionTree:
    """Return the tree in a message, in which each node precedes its branches."""
    made: list[Node] = []
    for node in reversed(message.nodes):
        counts = tuple(int(count) if count.is_integer() else count for count in node.counts)
        numbers = tuple(node.numbers)
        if node.kind == node.LEAF:
            made.append(Leaf(counts))
            continue
        test: Test
        match node.kind:
            case node.THRESHOLD:
                test = Threshold(numbers[0])
            case node.ARC:
                test = Arc(start=numbers[1], end=numbers[2], period=numbers[0])
            case _:
                test = Categories(tuple(map(int, numbers)))
        several = len(numbers) if node.kind == node.CATEGORY else 2
        branches = tuple(made.pop() for _ in range(several))
        made.append(Fork(node.feature, test, counts, branches))
    return TransitionTree.of(made.pop(), message.labels, scales)
