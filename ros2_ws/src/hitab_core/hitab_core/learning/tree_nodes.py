"""The nodes of a learned transition tree: frozen, comparable, without behavior.

A tree may be as deep as it has examples, so use `fold` and loops, never recursion.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, astuple, dataclass
from typing import Any, TypeVar

from hitab_core.learning.boundaries import on_circle

T = TypeVar("T")

Counts = tuple[float, ...]
"""The number of examples of each class: integers, or floats where some are there only in part."""


@dataclass(frozen=True, slots=True)
class Threshold:
    """Two branches: ``value <= threshold``, and the others; a boolean's threshold is 0.5."""

    threshold: float

    def branch_for(self, value: float) -> int | None:
        """Return the index of the branch that the value takes."""
        return 0 if value <= self.threshold else 1


@dataclass(frozen=True, slots=True)
class Arc:
    """Two branches: ``[start, end)`` counted upwards on the circle, and the others.

    If the arc passes zero, ``end < start``. Both ends are in [0, period).
    """

    start: float
    end: float
    period: float

    def branch_for(self, value: float) -> int | None:
        """Return the index of the branch that the value takes."""
        place = on_circle(value, self.period)
        if self.start < self.end:
            return 0 if self.start <= place < self.end else 1
        return 1 if self.end <= place < self.start else 0


@dataclass(frozen=True, slots=True)
class Categories:
    """One branch per category seen; other categories get the node's own distribution."""

    categories: tuple[int, ...]

    def branch_for(self, value: float) -> int | None:
        """Return the index of the branch that the value takes; None for an unseen category."""
        return self.categories.index(int(value)) if value in self.categories else None


Test = Threshold | Arc | Categories
_TESTS = (Threshold, Arc, Categories)


@dataclass(frozen=True, slots=True)
class Leaf:
    """The end of a path: the number of examples of each class."""

    counts: Counts

    @property
    def branches(self) -> tuple[Node, ...]:
        """No branches."""
        return ()


@dataclass(frozen=True, slots=True)
class Fork:
    """A test of a feature's value, with the examples that came to it and its branches."""

    feature: int
    test: Test
    counts: Counts
    branches: tuple[Node, ...]

    def branch_for(self, value: float) -> int | None:
        """Return the index of the branch that the value takes; None if there is none for it."""
        return self.test.branch_for(value)


Node = Leaf | Fork


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


@dataclass(frozen=True, slots=True)
class PlainNode:
    """A node without its branches, of plain fields: those of a `TreeNode` message."""

    kind: int = 0
    feature: int = 0
    numbers: tuple[float, ...] = ()
    counts: Counts = ()


def plain_nodes(root: Node) -> list[PlainNode]:
    """Return all nodes, each before its branches; `root_of` makes a tree of them."""
    return [
        PlainNode(counts=node.counts)
        if isinstance(node, Leaf)
        else PlainNode(
            1 + _TESTS.index(type(node.test)), node.feature, _numbers(node.test), node.counts
        )
        for node in nodes(root)
    ]


def _numbers(test: Test) -> tuple[float, ...]:
    return test.categories if isinstance(test, Categories) else astuple(test)


def root_of(plain: Sequence[PlainNode]) -> Node:
    """Return the root of the tree with these nodes, each before its branches."""
    made: list[Node] = []
    for node in reversed(plain):
        counts = tuple(int(n) if n.is_integer() else n for n in node.counts)
        if not node.kind:
            made.append(Leaf(counts))
            continue
        kind: Any = _TESTS[node.kind - 1]
        several = len(node.numbers) if kind is Categories else 2
        test = kind(tuple(map(int, node.numbers))) if kind is Categories else kind(*node.numbers)
        branches = tuple(made.pop() for _ in range(several))
        made.append(Fork(node.feature, test, counts, branches))
    return made.pop()


def described(node: Node) -> dict[str, object]:
    """Return a node, without its branches, as plain data with exact numbers (``float.hex``)."""
    plain: dict[str, object] = {"counts": node.counts}
    if isinstance(node, Fork):
        plain |= {"feature": node.feature, **asdict(node.test)}
    return {key: _exact(value) for key, value in plain.items()}


def _exact(value: Any) -> Any:
    if isinstance(value, tuple):
        return list(map(_exact, value))
    return value.hex() if isinstance(value, float) else value
