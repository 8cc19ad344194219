"""How sure a decision is: what it rests on, and how far it is from what was demonstrated.

*Support* is the number of examples in the leaf that decided, default examples apart from ordinary
ones. *Distance* is that of the situation from the nearest example of the state, in the features
that the decision tested, see `hitab_core.advice.nearness`. Both follow from the values that a
decision has read, so they can be computed after it, and nothing more is read.

If a tested value was missing, the decision was a mixture over the branches; its support is then
that of the weakest leaf that it could have come from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hitab_core.advice.evidence import Evidence
from hitab_core.advice.nearness import UNKNOWN, Nearness
from hitab_core.advice.support import Support, SupportedTree
from hitab_core.learning import Leaf, Node
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.learning.tree_nodes import nodes
from hitab_core.transition_function import TransitionFunction
from hitab_core.wording import quantity

_UNKNOWN = Support(float("nan"), float("nan"))


@dataclass(frozen=True, slots=True)
class Confidence:
    """How sure a decision is.

    Attributes:
        support: the examples in the leaf that decided; NaN if a classifier without leaves did.
        distance: from the nearest example, in spreads of the state's examples; 0 if nothing was
            tested, infinite if no example has the values.
    """

    support: Support
    distance: float

    def doubts(self, least_support: float, largest_distance: float) -> str:
        """Return why the decision is unsure, for people; empty if it is sure.

        Default examples count as support: a leaf that keeps a behavior going often has no others.

        Args:
            least_support: unsure if the leaf has fewer examples.
            largest_distance: unsure if no example is as near as this; 0: any distance will do.
        """
        found = []
        if self.support.examples < least_support:
            found.append(f"it rests on {_examples(self.support.examples)}")
        if self.distance == UNKNOWN and largest_distance > 0:
            found.append("no example has the values that it depends on")
        elif self.distance > largest_distance > 0:
            found.append(f"it is {self.distance:.2g} spreads of the examples from the nearest one")
        return " and ".join(found)


class Confidences:
    """Rates the decisions of one learned transition function, in some microseconds each."""

    __slots__ = ("_rated", "_tree", "_whole")

    def __init__(self, function: TransitionFunction, evidence: Evidence) -> None:
        """Prepare to rate; this takes about as long as learning the function.

        Args:
            function: a learned one; of a classifier that is no tree only the distance is rated.
            evidence: the examples that it was learned from.
        """
        self._whole = Nearness(evidence.values, evidence.scales, function.features_used)
        self._tree: SupportedTree | None = None
        self._rated: dict[int, tuple[Support, Nearness]] = {}
        if not isinstance(function, TransitionTree):
            return
        self._tree = supported = SupportedTree(function, evidence)
        waiting: list[tuple[Node, tuple[int, ...]]] = [(function.root_, ())]
        measures: dict[tuple[int, ...], Nearness] = {}
        while waiting:
            node, tested = waiting.pop()
            if not isinstance(node, Leaf):
                tested = tuple(sorted({*tested, node.feature}))
                waiting.extend((branch, tested) for branch in node.branches)
            if tested not in measures:
                measures[tested] = Nearness(evidence.values, evidence.scales, tested)
            self._rated[id(node)] = supported.support(node), measures[tested]

    def __call__(self, values: Sequence[float | None]) -> Confidence:
        """Return how sure a decision is.

        Args:
            values: of the automaton's features as the decision read them; None or NaN: not read
                or missing.
        """
        if self._tree is None:
            return Confidence(_UNKNOWN, self._whole(values))
        node: Node = self._tree.tree.root_
        while not isinstance(node, Leaf):
            value = values[node.feature]
            if value is None or value != value:
                return self._mixed(node, values)
            branch = node.branch_for(value)
            if branch is None:
                break
            node = node.branches[branch]
        support, nearness = self._rated[id(node)]
        return Confidence(support, nearness(values))

    def _mixed(self, root: Node, values: Sequence[float | None]) -> Confidence:
        """Return the confidence of a decision that could have come from several leaves."""
        leaves = [node for node in nodes(root) if isinstance(node, Leaf)]
        rated = [self._rated[id(leaf)] for leaf in leaves]
        weakest = min((support for support, _ in rated), key=lambda support: support.examples)
        return Confidence(weakest, max(nearness(values) for _, nearness in rated))


def _examples(number: float) -> str:
    return quantity(int(number), "example") if number == int(number) else f"{number:.2g} examples"
