"""The nodes of a learned transition tree: frozen, comparable, without behavior.

A tree may be as deep as it has examples, so use `fold` and loops, never recursion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from hitab_core.learning.boundaries import on_circle

T = TypeVar("T")

Counts = tuple[float, ...]
"""The number of examples of each class: integers, or floats where some are there only in part."""


@dataclass(frozen=True, slots=True)
class Leaf:
    """The end of a path: the number of examples of each class."""

    counts: Counts

    @property
    def branches(self) -> tuple[Node, ...]:
        """No branches."""
        return ()


@dataclass(frozen=True, slots=True)
class ThresholdNode:
    """``value <= threshold`` goes to ``low``, else to ``high``; a boolean's threshold is 0.5."""

    feature: int
    threshold: float
    counts: Counts
    low: Node
    high: Node

    @property
    def branches(self) -> tuple[Node, ...]:
        """Both branches."""
        return (self.low, self.high)

    def branch_for(self, value: float) -> int | None:
        """Return the index of the branch that the value takes."""
        return 0 if value <= self.threshold else 1


@dataclass(frozen=True, slots=True)
class ArcNode:
    """A value in the arc ``[start, end)`` goes to ``inside``, else to ``outside``.

    The arc runs upwards from ``start``; if it passes zero, ``end < start``. The outside is the arc
    ``[end, start)``. Both ends are in [0, period).
    """

    feature: int
    period: float
    start: float
    end: float
    counts: Counts
    inside: Node
    outside: Node

    @property
    def branches(self) -> tuple[Node, ...]:
        """Both branches."""
        return (self.inside, self.outside)

    def branch_for(self, value: float) -> int | None:
        """Return the index of the branch that the value takes."""
        place = on_circle(value, self.period)
        if self.start < self.end:
            return 0 if self.start <= place < self.end else 1
        return 1 if self.end <= place < self.start else 0


@dataclass(frozen=True, slots=True)
class CategoryNode:
    """One branch per category seen; other categories get this node's own distribution."""

    feature: int
    categories: tuple[int, ...]
    counts: Counts
    branches: tuple[Node, ...]

    @property
    def fallback(self) -> Leaf:
        """The leaf for categories that were not seen."""
        return Leaf(self.counts)

    def branch_for(self, value: float) -> int | None:
        """Return the index of the branch that the value takes; None for an unseen category."""
        return self.categories.index(int(value)) if value in self.categories else None


Node = Leaf | ThresholdNode | ArcNode | CategoryNode


def fold(root: Node, make: Callable[[Node, list[T]], T]) -> T:
    """Return ``make(root, parts)``, where parts are its results for the root's branches."""
    made: list[T] = []
    waiting: list[tuple[Node, bool]] = [(root, False)]
    while waiting:
        node, branches_are_made = waiting.pop()
        if branches_are_made or not node.branches:
            first = len(made) - len(node.branches)
            parts = made[first:]
            del made[first:]
            made.append(make(node, parts))
        else:
            waiting.append((node, True))
            waiting.extend((branch, False) for branch in reversed(node.branches))
    return made[0]


def nodes(root: Node) -> list[Node]:
    """Return all nodes, each before its branches, in the order of the branches."""
    found: list[Node] = []
    waiting = [root]
    while waiting:
        node = waiting.pop()
        found.append(node)
        waiting.extend(reversed(node.branches))
    return found


def described(node: Node) -> dict[str, object]:
    """Return a node, without its branches, as plain data with exact numbers (``float.hex``)."""
    counts = [n.hex() if isinstance(n, float) else n for n in node.counts]
    plain: dict[str, object] = {"counts": counts}
    if isinstance(node, ThresholdNode):
        plain |= {"feature": node.feature, "threshold": node.threshold.hex()}
    elif isinstance(node, ArcNode):
        plain |= {
            "feature": node.feature,
            "period": node.period.hex(),
            "start": node.start.hex(),
            "end": node.end.hex(),
        }
    elif isinstance(node, CategoryNode):
        plain |= {"feature": node.feature, "categories": list(node.categories)}
    return plain
