"""What an agent has learned, rebuilt from the answer of its service `get_behavior`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from hitab_core import (
    START,
    Automaton,
    Example,
    FeatureKind,
    HitabError,
    Scale,
    TransitionTree,
    Use,
)
from hitab_core.learning import TREE, ClassifierSpec, learn_transitions
from hitab_ros.conversions import example_of


@dataclass(frozen=True)
class Learned:
    """One automaton of an agent, as `GetBehavior` describes it.

    Attributes:
        origin: basic, hand-written, trained or training.
        parameters, arguments: the parameters, and their bindings during training.
        states: labels of its states; in training, of those that were chosen or commanded.
        chosen: labels of the states that were chosen when the training began; empty: any can be
            commanded, or it is not in training.
        features: labels, in the order of the examples' values.
        units, scales: of the features.
        examples: all of them.
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
    version: int = 0
    versions: tuple[int, ...] = ()
    created: str = ""
    note: str = ""
    difference: str = ""
    trimmed: tuple[str, ...] = ()
    chosen: tuple[str, ...] = ()

    @property
    def is_automaton(self) -> bool:
        """Whether it is more than a basic behavior."""
        return self.origin != "basic"

    @cached_property
    def automaton(self) -> Automaton | None:
        """The automaton with its trees; None if it has none, or they are unknown."""
        known = ClassifierSpec.parse(self.classifier or TREE).name == TREE
        if not self.examples or not known:
            return None
        try:
            learned = learn_transitions(self.examples, self.scales, self.classifier or TREE)
            labels = dict.fromkeys(
                s for e in self.examples for s in (e.state, e.next_state) if s != START
            )
            return Automaton(
                self.name,
                tuple(map(Use.parse, labels)),
                tuple(map(Use.parse, self.features)),
                learned,
                self.parameters,
                self.examples,
                self.description,
            )
        except HitabError:
            return None

    def tree(self, state: str) -> TransitionTree | None:
        """Return the tree of a state, if it has one."""
        automaton = self.automaton
        function = automaton.transitions.get(state) if automaton else None
        return function if isinstance(function, TransitionTree) else None

    def decides(self, state: str, values: Sequence[float]) -> Mapping[str, float]:
        """Return the probability of each next state; nothing if that is unknown."""
        tree = self.tree(state)
        if tree is None or any(math.isnan(v) for v in values):
            return {}
        return tree.explain(values, self.features).distribution


def learned_of(answer: Any) -> Learned:
    """Return the content of an answer of `GetBehavior`."""
    scales = [Scale(FeatureKind(f.kind), f.period, tuple(f.categories)) for f in answer.features]
    return Learned(
        name=answer.name,
        origin=answer.origin,
        description=answer.description,
        classifier=answer.classifier,
        parameters=tuple(answer.parameters),
        arguments=tuple(answer.arguments),
        states=tuple(answer.states),
        features=tuple(f.name for f in answer.features),
        units=tuple(f.unit for f in answer.features),
        scales=tuple(scales),
        examples=tuple(example_of(e) for e in answer.examples),
        version=answer.version,
        versions=tuple(answer.versions),
        created=answer.created,
        note=answer.note,
        difference=answer.difference,
        trimmed=tuple(answer.trimmed),
        chosen=tuple(answer.chosen_states),
    )
