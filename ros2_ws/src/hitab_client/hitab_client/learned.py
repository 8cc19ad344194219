"""Learned behaviors of an agent, from its topics and its service `get_behavior`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hitab_msgs.msg import Question

from hitab_core import (
    Automaton,
    BoundedNumber,
    Example,
    Remark,
    Scale,
    Term,
    TransitionTree,
    with_numbers,
)
from hitab_core.assistant import TrainingCost
from hitab_core.codec import fields_of, from_dict
from hitab_core.learning import root_of
from hitab_core.regression import Neighbors, learn_numbers
from hitab_ros.messages.conversions import numbers_of_behaviors, remarks_of


@dataclass(frozen=True)
class Learned(Automaton):
    """A behavior of an agent, and what is known of it; a basic one has no states.

    Attributes:
        transitions: transition trees, by state; none if it has no examples, or is hand-written, or
            has another classifier.
        origin: "basic", "hand-written", "trained" or "training".
        arguments: targets of the parameters during training.
        chosen_states: labels of the states chosen when the training began; empty if any state can
            be commanded, or without a training.
        units, scales: units and scales of the features.
        with_numbers: numbers of the behaviors that take numbers, by name.
    """

    transitions: Mapping[str, TransitionTree]
    numbers: Mapping[str, Neighbors] = field(default_factory=dict, compare=False)
    origin: str = "trained"
    classifier: str = ""
    arguments: tuple[str, ...] = ()
    chosen_states: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    scales: tuple[Scale, ...] = ()
    with_numbers: Mapping[str, tuple[BoundedNumber, ...]] = field(default_factory=dict)
    version: int = 0
    versions: tuple[int, ...] = ()
    created: str = ""
    note: str = ""
    difference: str = ""
    trimmed: tuple[str, ...] = ()

    @property
    def possible_states(self) -> tuple[str, ...]:
        """Labels of the states; in training, of the chosen and the commanded ones."""
        return tuple(dict.fromkeys((*self.chosen_states, *self.labels)))

    @property
    def is_automaton(self) -> bool:
        """Whether this is an automaton, not a basic behavior."""
        return self.origin != "basic"

    def numbers_of(self, state: Term) -> tuple[BoundedNumber, ...]:
        """Return the numbers that a state's behavior takes."""
        return self.with_numbers.get(state.name, ())

    def commanded(self, example: Example) -> str:
        """Return an example's next state with its numbers, as ``RunTowards(direction=40)``."""
        state = Term.parse(example.next_state)
        return str(with_numbers(state, example.numbers, self.numbers_of(state)))

    def decides(self, state: str, values: Sequence[float]) -> Mapping[str, float]:
        """Return the probability of each next state; empty if unknown."""
        tree = self.transitions.get(state)
        if tree is None or any(math.isnan(v) for v in values):
            return {}
        return tree.explain(values, self.feature_labels).distribution


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
    return from_dict(Learned, answer, **_automaton_fields(answer.automaton))


def training_of(message: Any) -> Training:
    """Return the content of a message about a training."""
    return from_dict(
        Training,
        message,
        origin="training",
        questions=tuple(message.questions),
        remarks=remarks_of(message.remarks),
        cost=from_dict(TrainingCost, message.cost) if message.cost.automaton else None,
        **_automaton_fields(message.automaton),
    )


def _automaton_fields(message: Any) -> dict[str, Any]:
    scales = tuple(from_dict(Scale, feature) for feature in message.features)
    wanted = numbers_of_behaviors(message.with_numbers)
    more = {
        "features": tuple(Term.parse(feature.name) for feature in message.features),
        "units": tuple(feature.unit for feature in message.features),
        "scales": scales,
        "with_numbers": wanted,
        "transitions": {
            tree.state: TransitionTree.of(root_of(tree.nodes), tree.labels, scales)
            for tree in message.trees
        },
    }
    found = fields_of(Learned, message, more)
    found["numbers"] = learn_numbers(
        found["states"], scales, found["examples"], lambda state: wanted.get(state.name, ())
    )
    return found | more
