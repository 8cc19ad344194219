"""Questions about the side of a circle on which a command was never shown.

"In ApproachBall, you showed TurnToBall on one side only, at DirectionTo(ball) = 10 deg. Is it
right on the other side, too, with DirectionTo(ball) = -10 deg?" On a circle a command among
default examples holds for the side on which it was given (`hitab_core.learning.boundaries`). On
the other side the default example reaches to the place opposite to it, and nobody has said that it
should. Whoever shows how to turn to the left often means the right as well; but who turns away
from a wall may mean one side. The examples cannot tell, and one command can.

**Where it is asked.** As far from the default example as the command is on its own side, so that
what is learned is as exact on both sides. If the answer is to stay, the command was perhaps only
meant farther on: it is asked again, twice as far, up to a quarter of the circle, within which the
command itself would hold for a side.

**When it is asked.** Only about circles that the learned tree tests, where half the circle beside
the default examples is without any command; and not if the agent has perceived much, and never
anything on that half.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hitab_core.advice.evidence import Evidence
from hitab_core.advice.grounds import around, branches_of, situation_in_words
from hitab_core.advice.situations import Perceived
from hitab_core.arrays import Booleans
from hitab_core.learning import Leaf, Node
from hitab_core.learning.boundaries import on_circle
from hitab_core.learning.tree_nodes import ArcNode

POINT = 1e-6
"""Width of an arc, as a share of the circle, that is a single direction: nobody means one."""

BESIDE = 1 / 60
"""How far from a single value it is asked, as a share of the circle: 6 degrees."""

LEAST = 1 / 720
"""The least such distance, as a share of the circle."""


@dataclass(frozen=True, slots=True)
class UnshownSide:
    """A side of a circle on which a command was not shown.

    Attributes:
        state: whose decision it is about.
        next_state: that was commanded on the other side.
        feature: index of the circle.
        shown: positions of the examples of the command nearest to the default ones, among those
            of the state.
        situation: in which to ask: a value for each feature; NaN: any.
        share: how often the agent was there, as a share of the readings in the state.
        text: the question.
        one_value: whether the command was shown at one value only, see `lone_values`.
    """

    state: str
    next_state: str
    feature: int
    shown: tuple[int, ...]
    situation: tuple[float, ...]
    share: float
    text: str
    one_value: bool = False


@dataclass(frozen=True, slots=True)
class _Gap:
    """The part of a circle between a default example and the next one of a command.

    Attributes:
        default, shown: their values.
        up: 1 if the way from the default example to the other one leads upwards, else -1.
        width: of that way.
    """

    default: float
    shown: float
    up: int
    width: float


class Circles:
    """The circles that the tree of a state tests, and what was perceived: learned once for both.

    Args:
        evidence: the examples of the state.
        readings, here: see `hitab_core.advice.ambiguity.ambiguities`.

    Raises:
        FeatureValueError, VocabularyError, ValueError: as learning from the examples.
    """

    def __init__(
        self, evidence: Evidence, readings: ArrayLike = (), here: ArrayLike | None = None
    ) -> None:
        self.evidence = evidence
        self.perceived = Perceived.of(evidence, readings, here)
        tree = evidence.learn()  # None: another classifier than a tree is learned
        self.tested = tree.features_used if tree is not None else ()
        self.arcs = list(_arcs(tree.root_, evidence)) if tree is not None else []


def unshown_sides(circles: Circles) -> list[UnshownSide]:
    """Return the sides of circles to ask about, those that occur most often first."""
    evidence, perceived = circles.evidence, circles.perceived
    found = []
    for node, there in circles.arcs:
        gaps = _gaps(node, there, evidence)
        place = gaps and _place(node, *gaps)
        if gaps is None or place is None:
            continue
        narrow, wide = gaps
        beyond = (perceived.values[:, node.feature] - wide.default) * wide.up % node.period
        on_it = (beyond > 0) & (beyond < node.period / 2)  # NaN is not
        if perceived.enough and not on_it.any():
            continue  # it hardly ever comes there
        here_times = perceived.times * perceived.here
        share = float(here_times[on_it].sum() / here_times.sum())
        column = evidence.values[:, node.feature]
        rows = np.flatnonzero(there & (column == narrow.shown) & ~evidence.default).tolist()
        found.append(_asked(circles, node.feature, rows, place, share))
    return sorted(found, key=lambda side: -side.share)


def lone_values(circles: Circles) -> list[UnshownSide]:
    """Return what to ask about commands that hold for a single value, which did not occur again.

    Between default examples on both sides a command holds for what was commanded only. A sensor
    that rounds meets such a value again; one that measures never does, and the command is lost. It
    is asked on the side from which the value was mostly approached, a little beside it, or after
    the answer to stay, half as far.
    """
    evidence, perceived = circles.evidence, circles.perceived
    found = []
    for node, there in circles.arcs:
        period, column = node.period, evidence.values[:, node.feature]
        width = (node.end - node.start) % period
        if min(width, period - width) >= POINT * period:
            continue
        alone = int(width > period / 2)  # the branch of the arc itself, or of the rest
        values = np.unique(column[there])
        own = [value for value in values if node.branch_for(value) == alone]
        rows = np.flatnonzero(there & np.isin(column, own) & ~evidence.default).tolist()
        if len(own) != 1 or not rows or len(values) < 2:
            continue
        again = perceived.times[perceived.values[:, node.feature] == own[0]].sum()
        if again > np.count_nonzero(column == own[0]):
            continue
        ways = (values - own[0]) % period
        gaps = {1: float(ways[ways > 0].min()), -1: float(period - ways.max())}
        met = (perceived.values[:, node.feature] - own[0]) % period
        seen = perceived.times * perceived.here
        beside = {1: seen[(met > 0) & (met < gaps[1])].sum()}
        beside[-1] = seen[met > period - gaps[-1]].sum()
        up = max(gaps, key=lambda way: (beside[way], -gaps[way]))
        away = min(gaps[up] / 2, BESIDE * period)
        if away >= LEAST * period:
            place = on_circle(own[0] + up * away, period)
            found.append(_asked(circles, node.feature, rows, place, 0.0, one_value=True))
    return found


def _arcs(root: Node, evidence: Evidence) -> Iterator[tuple[ArcNode, Booleans]]:
    """Yield the nodes of a tree that test a circle, with the examples whose values they test."""
    waiting = [(root, np.ones(len(evidence.next_states), np.bool_))]
    while waiting:
        node, there = waiting.pop()
        if isinstance(node, Leaf):
            continue
        column = evidence.values[:, node.feature]
        if isinstance(node, ArcNode):
            yield node, there & ~np.isnan(column)
        branch_of = branches_of(node, column)
        for i, branch in enumerate(node.branches):
            waiting.append((branch, there & ((branch_of == i) | (branch_of == -1))))


def _gaps(node: ArcNode, there: Booleans, evidence: Evidence) -> tuple[_Gap, _Gap] | None:
    """Return the gaps beside the default examples of one branch, the narrower one first.

    Returns:
        None if the examples beside the ends of the arc are not default ones on the same branch,
        and others on the other one.
    """
    column = evidence.values[:, node.feature]
    values = np.unique(column[there])
    if len(values) < 2:
        return None

    def is_kept(value: float) -> bool:
        return bool(evidence.default[there & (column == value)].all())

    found, kept = [], set()
    for end, upper_branch in ((node.start, 0), (node.end, 1)):
        below, above = around(values, end, node.period)
        if is_kept(below) == is_kept(above):
            return None
        width = (above - below) % node.period
        if is_kept(below):
            kept.add(1 - upper_branch)
            found.append(_Gap(below, above, 1, width))
        else:
            kept.add(upper_branch)
            found.append(_Gap(above, below, -1, width))
    if len(kept) != 1:
        return None
    narrow, wide = sorted(found, key=lambda gap: gap.width)
    return narrow, wide


def _place(node: ArcNode, narrow: _Gap, wide: _Gap) -> float | None:
    """Return where to ask in the wider gap; None if nothing is to be asked."""
    period = node.period
    kept = (narrow.default - wide.default) * -wide.up % period
    away = max(narrow.width, kept)
    if wide.width <= period / 2 or kept + away > period / 4:
        return None
    place = on_circle(wide.default + wide.up * away, period)
    return place if node.branch_for(place) == node.branch_for(wide.default) else None


def _asked(
    circles: Circles,
    feature: int,
    rows: Sequence[int],
    place: float,
    share: float,
    *,
    one_value: bool = False,
) -> UnshownSide:
    """Return what to ask.

    Args:
        circles: of the state.
        feature, share, one_value: see `UnshownSide`.
        rows: positions of the nearest examples on the other side, oldest first; or of those with
            the one value.
        place: value of the feature where to ask.
    """
    evidence, last = circles.evidence, rows[-1]
    label = evidence.next_states[last]
    there = tuple(evidence.values[last].tolist())
    situation = (*there[:feature], place, *there[feature + 1 :])
    shown = situation_in_words(evidence, there, [feature])
    where = situation_in_words(evidence, situation, circles.tested)
    if one_value:
        told = f"at {shown} only, which has not occurred again. Is it right with {where}, too?"
    else:
        told = f"on one side only, at {shown}. Is it right on the other side, too, with {where}?"
    return UnshownSide(
        evidence.state,
        label,
        feature,
        tuple(row for row in rows if evidence.next_states[row] == label),
        situation,
        share,
        f"In {evidence.state}, you showed {label} {told}",
        one_value,
    )
