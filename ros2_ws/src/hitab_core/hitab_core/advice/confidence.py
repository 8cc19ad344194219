"""Confidence of a decision: the distance of its situation from the examples.

It is the distance from the nearest example of the state, in the features that the decision
tested, see `hitab_core.advice.nearness`. It follows from the values that a decision has read, so
it can be computed after it, and nothing more is read.

If a tested value was missing, the decision was a mixture over the branches; its distance is then
the largest of its possible leaves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from hitab_core.advice.evidence import Evidence
from hitab_core.advice.nearness import UNKNOWN_DISTANCE, Nearness
from hitab_core.domain import Domain
from hitab_core.example import Example
from hitab_core.learning import Leaf, Node
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.term import Term
from hitab_core.transition_function import TransitionFunction

FAR = 3.0
"""Distance of a far decision from the nearest example, in spreads of the state's examples."""

RATED_MAX = 1000
"""Maximum number of functions with confidences; each learning makes new functions."""


class Confidences:
    """Rates the decisions of one learned transition function.

    Args:
        function: a learned one; one that is no tree tests all of its features.
        evidence: the examples learned from.
    """

    def __init__(self, function: TransitionFunction, evidence: Evidence) -> None:
        self._function = function
        self._evidence = evidence
        self._measures: dict[frozenset[int], Nearness] = {}

    def doubts(self, values: Sequence[float | None], largest: float) -> str:
        """Return why a decision is unsure, for people; empty if it is sure.

        Args:
            values: see `distance`.
            largest: largest distance from the nearest example at which a decision is sure.
        """
        distance = self.distance(values)
        if distance == UNKNOWN_DISTANCE:
            return "no example has values of its features"
        if distance > largest:
            return f"it is {distance:.2g} spreads of the examples from the nearest one"
        return ""

    def decided(self, values: Sequence[float | None]) -> float:
        """Return the distance of a decision that was made; NaN if it was not made from these.

        Args:
            values: see `distance`. A value that the decision needs is missing if another state
                decided, or nothing did.
        """
        if not isinstance(self._function, TransitionTree):
            used = self._function.features_used
            return math.nan if any(values[f] is None for f in used) else self.distance(values)
        node, tested = self._function.root_, []
        while not isinstance(node, Leaf):
            value = values[node.feature]
            if value is None:
                return math.nan
            tested.append(node.feature)
            branch = node.branch_for(value)
            if value != value or branch is None:
                return self.distance(values)
            node = node.branches[branch]
        return self._distance(frozenset(tested), values)

    def distance(self, values: Sequence[float | None]) -> float:
        """Return the distance of a decision from the nearest example.

        It is in spreads of the state's examples; 0 if nothing was tested, infinite if no example
        has the values.

        Args:
            values: values of the automaton's features as the decision read them; None if not
                read, NaN if missing.
        """
        if not isinstance(self._function, TransitionTree):
            return self._distance(frozenset(self._function.features_used), values)
        found = []
        waiting: list[tuple[Node, frozenset[int]]] = [(self._function.root_, frozenset())]
        while waiting:
            node, tested = waiting.pop()
            if isinstance(node, Leaf):
                found.append(self._distance(tested, values))
                continue
            value = values[node.feature]
            tested |= {node.feature}
            if value is None or value != value:
                waiting += [(branch, tested) for branch in node.branches]
                continue
            branch = node.branch_for(value)
            if branch is None:
                found.append(self._distance(tested, values))
            else:
                waiting.append((node.branches[branch], tested))
        return max(found)

    def _distance(self, tested: frozenset[int], values: Sequence[float | None]) -> float:
        if tested not in self._measures:
            known = self._evidence
            self._measures[tested] = Nearness(known.values, known.scales, sorted(tested))
        return self._measures[tested](values)


class RatedFunctions:
    """The `Confidences` of learned transition functions, made when they are first needed."""

    def __init__(self) -> None:
        self._rated: dict[tuple[int, str], tuple[TransitionFunction, Confidences]] = {}

    def of(
        self,
        function: TransitionFunction,
        state: str,
        features: Sequence[Term],
        examples: Sequence[Example],
        domain: Domain,
    ) -> Confidences:
        """Return the confidences of a state's function, learned from examples of all states."""
        rated = self._rated.get((id(function), state))
        if rated is None or rated[0] is not function:
            if len(self._rated) >= RATED_MAX:
                self._rated.clear()
            scales = list(map(domain.scale_of, features))
            evidence = Evidence.of(state, examples, scales, list(map(str, features)))
            rated = self._rated[id(function), state] = function, Confidences(function, evidence)
        return rated[1]
