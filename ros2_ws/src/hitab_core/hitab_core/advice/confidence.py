"""How sure a decision is: what it rests on, and how far it is from what was demonstrated.

*Support* is the number of examples in the leaf that decided, parts of examples added up.
*Distance* is that of the situation from the nearest example of the state, in the features that the
decision tested, see `hitab_core.advice.nearness`. Both follow from the values that a decision has
read, so they can be computed after it, and nothing more is read.

If a tested value was missing, the decision was a mixture over the branches; its support is then
that of the weakest leaf that it could have come from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hitab_core.advice.evidence import Evidence
from hitab_core.advice.nearness import UNKNOWN, Nearness
from hitab_core.learning import Leaf, Node
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.transition_function import TransitionFunction
from hitab_core.wording import quantity


@dataclass(frozen=True, slots=True)
class Confidence:
    """How sure a decision is.

    Attributes:
        support: the examples in the leaf that decided; NaN if a classifier without leaves did.
        distance: from the nearest example, in spreads of the state's examples; 0 if nothing was
            tested, infinite if no example has the values.
    """

    support: float
    distance: float

    def doubts(self, least_support: float, largest_distance: float) -> str:
        """Return why the decision is unsure, for people; empty if it is sure.

        Default examples count as support: a leaf that keeps a behavior going often has no others.

        Args:
            least_support: unsure if the leaf has fewer examples.
            largest_distance: unsure if no example is as near as this; 0: any distance will do.
        """
        found = []
        if self.support < least_support:
            found.append(f"it rests on {_examples(self.support)}")
        if self.distance == UNKNOWN and largest_distance > 0:
            found.append("no example has the values that it depends on")
        elif self.distance > largest_distance > 0:
            found.append(f"it is {self.distance:.2g} spreads of the examples from the nearest one")
        return " and ".join(found)


class Confidences:
    """Rates the decisions of one learned transition function.

    Args:
        function: a learned one; of a classifier that is no tree only the distance is rated.
        evidence: the examples that it was learned from.
    """

    def __init__(self, function: TransitionFunction, evidence: Evidence) -> None:
        self._function = function
        self._evidence = evidence
        self._measures: dict[frozenset[int], Nearness] = {}

    def __call__(self, values: Sequence[float | None]) -> Confidence:
        """Return how sure a decision is.

        Args:
            values: of the automaton's features as the decision read them; None or NaN: not read
                or missing.
        """
        if not isinstance(self._function, TransitionTree):
            used = frozenset(self._function.features_used)
            return Confidence(float("nan"), self._distance(used, values))
        node: Node = self._function.root_
        tested: frozenset[int] = frozenset()
        while not isinstance(node, Leaf):
            value = values[node.feature]
            if value is None or value != value:
                return self._mixed(node, tested, values)
            tested |= {node.feature}
            branch = node.branch_for(value)
            if branch is None:
                break
            node = node.branches[branch]
        return Confidence(sum(node.counts), self._distance(tested, values))

    def _mixed(
        self, root: Node, tested: frozenset[int], values: Sequence[float | None]
    ) -> Confidence:
        """Return the confidence of a decision that could have come from several leaves."""
        found = []
        waiting = [(root, tested)]
        while waiting:
            node, tested = waiting.pop()
            if isinstance(node, Leaf):
                found.append((sum(node.counts), self._distance(tested, values)))
            else:
                tested |= {node.feature}
                waiting += [(branch, tested) for branch in node.branches]
        return Confidence(min(n for n, _ in found), max(away for _, away in found))

    def _distance(self, tested: frozenset[int], values: Sequence[float | None]) -> float:
        if tested not in self._measures:
            known = self._evidence
            self._measures[tested] = Nearness(known.values, known.scales, sorted(tested))
        return self._measures[tested](values)


def _examples(number: float) -> str:
    return quantity(int(number), "example") if number == int(number) else f"{number:.2g} examples"
