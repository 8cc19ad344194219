"""A transition tree in words: conditions, one rule per leaf, and a drawing.

Numbers are rounded to six digits, or to as many as distinguish the ends of an interval. A number
just beside a short one, such as a threshold next to an example, is written as the short one, and
``<`` or ``>=`` gives the side. Arcs are written within half a circle on either side of zero, so
that the lower end comes first: ``in -10..10``, and ``outside -10..10`` for the rest of the circle,
which contains 180 degrees. Angles of features in radians are written in degrees, to a tenth if
that distinguishes them. The exact numbers are in the files.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from hitab_core.domain import FeatureKind, Scale
from hitab_core.learning.tree_nodes import Arc, Categories, Fork, Leaf, Node
from hitab_core.texts.wording import DEGREES, quantity

Step = tuple[Fork, int | None]
"""A node on a path and the branch taken there; None for a category that was not seen."""

Interval = tuple[float, float]

DIGITS = 6
"""Digits of a number, unless more are needed to distinguish two."""

ROUNDING = 1e-12
"""Numbers that differ by less, as a part of them, are the same but for rounding."""

NEGLIGIBLE = 1e-300


@dataclass(frozen=True, slots=True)
class Rule:
    """Decision of a tree where a set of conditions holds.

    Attributes:
        conditions: readable; at most one per feature.
        distribution: probability of each possible next state, by label.
        examples: number of examples behind it; a fraction if some lacked a value.
    """

    conditions: tuple[str, ...]
    distribution: Mapping[str, float]
    examples: float

    def __str__(self) -> str:
        """Return ``if A and B: Stop 0.75, GoFast 0.25 (4 examples)``."""
        given = f"if {' and '.join(self.conditions)}" if self.conditions else "always"
        learned_from = quantity(number_of(self.examples), "example")
        return f"{given}: {as_odds(self.distribution)} ({learned_from})"


def number_of(examples: float) -> float:
    """Return a number of examples as it is written: whole, or to two decimals."""
    return int(examples) if examples == int(examples) else round(examples, 2)


def as_odds(distribution: Mapping[str, float]) -> str:
    """Return ``Stop`` if that is certain, else ``Stop 0.75, GoFast 0.25``."""
    if len(distribution) == 1:
        return next(iter(distribution))
    return ", ".join(f"{label} {p:.3g}" for label, p in distribution.items())


def distribution(counts: Sequence[float], labels: Sequence[str]) -> dict[str, float]:
    """Return the probability of each label that was seen."""
    total = sum(counts)
    return {label: n / total for label, n in zip(labels, counts, strict=True) if n}


def in_degrees(scale: Scale) -> bool:
    """Whether the values of a feature go around once in 2π, so that they are angles in radians."""
    return scale.kind is FeatureKind.TOROIDAL and math.isclose(scale.period, math.tau)


def conditions(
    path: Sequence[Step], scales: Sequence[Scale], names: Sequence[str]
) -> tuple[str, ...]:
    """Return the conditions on a path, with all tests of a feature merged into one.

    Args:
        path: the tests.
        scales: scales of the features.
        names: names of the features.
    """
    by_feature: dict[int, list[Step]] = {}
    for step in path:
        by_feature.setdefault(step[0].feature, []).append(step)
    return tuple(
        _condition(steps, scales[feature], names[feature]) for feature, steps in by_feature.items()
    )


def _condition(steps: Sequence[Step], scale: Scale, name: str) -> str:
    low, high = -math.inf, math.inf
    arcs: list[Interval] = [(0.0, math.inf)]
    for node, branch in steps:
        test = node.test
        if isinstance(test, Categories):
            return _category(test, branch, scale, name)
        if isinstance(test, Arc):
            start, end = (test.start, test.end) if branch == 0 else (test.end, test.start)
            arcs = _common(arcs, _intervals(start, end, test.period))
        elif branch == 0:
            high = test.threshold  # each threshold on a path lies between earlier ones
        else:
            low = test.threshold
    if scale.kind is FeatureKind.TOROIDAL:
        return f"{name} {_arcs(arcs, scale)}"
    if scale.kind is FeatureKind.BOOLEAN:
        return name if low > 0 else f"not {name}"
    return _range(low, high, name)


def _range(low: float, high: float, name: str) -> str:
    """Return ``low < value <= high`` in words."""
    (least, least_side), (most, most_side) = _short(low), _short(high)
    digits = DIGITS
    while least == most and high - low > max(ROUNDING * abs(high), NEGLIGIBLE) and digits < 17:
        digits += 1  # there is more than one number in between, and six digits do not show it
        (least, least_side), (most, most_side) = _short(low, digits), _short(high, digits)
    if least == most:
        return f"{name} = {most}"
    at_most = "<" if most_side < 0 else "<="
    if low == -math.inf:
        return f"{name} {at_most} {most}"
    if high == math.inf:
        return f"{name} {'>=' if least_side < 0 else '>'} {least}"
    return f"{least} {'<=' if least_side < 0 else '<'} {name} {at_most} {most}"


def _short(number: float, digits: int = DIGITS, negligible: float = NEGLIGIBLE) -> tuple[str, int]:
    """Return a number in a few digits, and 1 or -1 if it lies just above or below that.

    Args:
        number: the number to write.
        digits: number of digits.
        negligible: magnitude up to which a number counts as zero.
    """
    text = "0" if abs(number) < negligible else f"{number:.{digits}g}"
    written = float(text)
    if written == number or abs(number - written) > max(ROUNDING * abs(number), negligible):
        return text, 0
    return text, 1 if number > written else -1


def _category(test: Categories, branch: int | None, scale: Scale, name: str) -> str:
    known = dict(enumerate(scale.categories))
    called = [known.get(category, str(category)) for category in test.categories]
    return (
        f"{name} = {called[branch]}"
        if branch is not None
        else (f"{name} is none of {', '.join(called)}")
    )


def _intervals(start: float, end: float, period: float) -> list[Interval]:
    """Return the arc ``[start, end)`` cut at zero."""
    if start < end:
        return [(start, end)]
    return [(0.0, end), (start, period)] if end > 0 else [(start, period)]


def _common(some: Sequence[Interval], others: Sequence[Interval]) -> list[Interval]:
    common = [(max(a[0], b[0]), min(a[1], b[1])) for a in some for b in others]
    return sorted(interval for interval in common if interval[0] < interval[1])


def _arcs(intervals: list[Interval], scale: Scale) -> str:
    if len(intervals) > 1 and intervals[0][0] == 0.0 and intervals[-1][1] == scale.period:
        intervals = [*intervals[1:-1], (intervals[-1][0], intervals[0][1])]
    return " or ".join(_arc(start, end, scale) for start, end in intervals)


def _arc(start: float, end: float, scale: Scale) -> str:
    first, last = (_place(place, scale) for place in (start, end))
    behind = f" {DEGREES}" if in_degrees(scale) else ""
    if first == last:
        equal = "=" if (end - start) % scale.period < scale.period / 2 else "!="
        return f"{equal} {first}{behind if first != '0' else ''}"
    if in_degrees(scale):
        tenths = [f"{round(float(place), 1) + 0.0:g}" for place in (first, last)]
        first, last = tenths if tenths[0] != tenths[1] else (first, last)
    if first == _place(scale.period / 2, scale):
        first = f"-{first}"  # half-way around is written below zero where an arc begins
    low, high = float(first), float(last)
    return f"in {first}..{last}{behind}" if low < high else f"outside {last}..{first}{behind}"


def _place(place: float, scale: Scale) -> str:
    """Return a place on a circle, within half of it on either side of zero."""
    half = scale.period / 2
    signed, half_text = (place - scale.period if place > half else place), f"{half:.6g}"
    if in_degrees(scale):
        signed, half_text = math.degrees(signed), "180"
    text, _ = _short(signed, negligible=ROUNDING * scale.period)
    return half_text if text == f"-{half_text}" else text


def _ways_on(node: Fork, scale: Scale) -> list[int | None]:
    """Return the branches of a node, plus None if it has not seen all categories."""
    ways: list[int | None] = list(range(len(node.branches)))
    if isinstance(node.test, Categories) and len(scale.categories) != len(ways):
        ways.append(None)
    return ways


def _paths(root: Node, scales: Sequence[Scale]) -> Iterator[tuple[Node, tuple[Step, ...]]]:
    """Yield all nodes, each before its branches, with the path to each."""
    waiting: list[tuple[Node, tuple[Step, ...]]] = [(root, ())]
    while waiting:
        node, path = waiting.pop()
        yield node, path
        if isinstance(node, Leaf):
            continue
        for way in reversed(_ways_on(node, scales[node.feature])):
            branch = node.branches[way] if way is not None else Leaf(node.counts)
            waiting.append((branch, (*path, (node, way))))


def rules(
    root: Node, labels: Sequence[str], scales: Sequence[Scale], names: Sequence[str]
) -> list[Rule]:
    """Return one rule per leaf, in the order of the drawing."""
    leaves = [(node, path) for node, path in _paths(root, scales) if isinstance(node, Leaf)]
    rules = [conditions(path, scales, names) for _, path in leaves]
    exact = {condition for one in rules for condition in one if " = " in condition}
    return [
        Rule(
            tuple(_beside(condition, exact) for condition in one),
            distribution(node.counts, labels),
            sum(node.counts),
        )
        for one, (node, _) in zip(rules, leaves, strict=True)
    ]


def _beside(condition: str, exact: Collection[str]) -> str:
    """Return a condition that does not seem to hold for a number to which another rule belongs.

    Args:
        condition: such as ``X <= 1``, which means less than 1 if that was rounded.
        exact: conditions that hold for one number, such as ``X = 1``.
    """
    equal = condition.replace(" <= ", " = ", 1).replace(" >= ", " = ", 1)
    if equal in exact and equal != condition:
        return condition.replace(" <= ", " < ", 1).replace(" >= ", " > ", 1)
    return condition


Row = tuple[int, str, Node, tuple[Step, ...]]
"""The depth of a row, its condition, its node and the path to that."""


def rows(root: Node, scales: Sequence[Scale], names: Sequence[str]) -> Iterator[Row]:
    """Yield the rows of a drawing: a branch each, below its parent branch.

    Consecutive tests of one feature are one row with a single condition. Nested intervals are not
    repeated: each row has only the rest of the interval around it.
    """
    for node, path in _paths(root, scales):
        tested = [step[0].feature for step in path]
        if isinstance(node, Fork) and tested[-1:] in ([], [node.feature]):
            continue
        depth = sum(one != other for one, other in pairwise(tested))
        together = [step for step in path if step[0].feature == tested[-1]]
        yield depth, "".join(conditions(together, scales, names)), node, path


def drawing(
    root: Node, labels: Sequence[str], scales: Sequence[Scale], names: Sequence[str]
) -> str:
    """Return the tree as C4.5 draws one: a line per branch, indented by depth."""
    lines = []
    for depth, text, node, _ in rows(root, scales, names):
        if isinstance(node, Leaf):
            odds = as_odds(distribution(node.counts, labels))
            text += f"{': ' if text else ''}{odds} ({number_of(sum(node.counts))})"
        lines.append("|   " * depth + text)
    return "\n".join(lines)
