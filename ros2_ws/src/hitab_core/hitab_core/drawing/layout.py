"""Layout of an automaton's states and of the words on its arrows. Lengths are in inches.

States lie on an ellipse, Start at the top, in the order with the fewest crossings. Labels are
moved along their arrows, beside them, until they cover neither states nor other labels and no
arrow crosses them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BENDS = (0.06, 0.1, 0.14, 0.18, 0.22, 0.26, 0.31, 0.36)
"""Bows of an arrow to its right, as fractions of its length; less is better."""

FREE_INCHES = 0.06
"""Inches left free around labels and states."""


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle, by its middle and its size."""

    x: float
    y: float
    width: float
    height: float

    def share(self, points: Floats) -> float:
        """Return the fraction of points, shape (n, 2), that lie inside."""
        near = np.abs(points - (self.x, self.y)) <= (self.width / 2, self.height / 2)
        return float(near.all(axis=1).mean())

    def touches(self, other: Box) -> bool:
        """Whether the two have a place in common."""
        return (
            abs(self.x - other.x) < (self.width + other.width) / 2
            and abs(self.y - other.y) < (self.height + other.height) / 2
        )


def on_ellipse(n: int, width: float, height: float) -> list[tuple[float, float]]:
    """Return n places on an ellipse, clockwise from the top."""
    if n == 1:
        return [(0.0, 0.0)]
    angles = [math.pi / 2 - 2 * math.pi * i / n for i in range(n)]
    return [(width / 2 * math.cos(a), height / 2 * math.sin(a)) for a in angles]


def least_crossed(states: Sequence[str], pairs: Sequence[tuple[str, str]]) -> list[str]:
    """Return states in an order around a circle that keeps arrows short and crossings few.

    The first stays first.
    """
    order = list(states)
    ends = [tuple(sorted(pair)) for pair in dict.fromkeys(pairs) if pair[0] != pair[1]]

    def cost(order: Sequence[str]) -> float:
        n = len(order)
        place = {state: i for i, state in enumerate(order)}
        chords = [sorted((place[a], place[b])) for a, b in ends]
        length = sum(min(b - a, n - b + a) for a, b in chords)
        crossings = sum(a < c < b < d for a, b in chords for c, d in chords)
        return length + 3.0 * crossings

    best, better = cost(order), True
    while better:
        better = False
        for i in range(1, len(order)):
            for j in range(i + 1, len(order)):
                swapped = order.copy()
                swapped[i], swapped[j] = swapped[j], swapped[i]
                if (found := cost(swapped)) < best - 1e-9:
                    order, best, better = swapped, found, True
    return order


def curve(start: Box, end: Box, bend: float, points: int = 41) -> Floats:
    """Return points, shape (points, 2), on the arrow between two states, from middle to middle.

    It is the quadratic curve that matplotlib calls ``arc3``.
    """
    a, b = np.array([start.x, start.y]), np.array([end.x, end.y])
    across = np.array([b[1] - a[1], a[0] - b[0]])
    control = (a + b) / 2 + bend * across
    t = np.linspace(0.0, 1.0, points)[:, None]
    drawn: Floats = (1 - t) ** 2 * a + 2 * t * (1 - t) * control + t**2 * b
    return drawn


def bend_arrows(
    boxes: Mapping[str, Box], pairs: Sequence[tuple[str, str]], width: float, height: float
) -> list[float]:
    """Return how far each arrow bows out to clear other states.

    Args:
        boxes: where the states are.
        pairs: source and target of each arrow.
        width, height: of the panel around the origin.
    """
    panel = Box(0.0, 0.0, width, height)
    chosen = []
    for source, target in pairs:
        others = [_roomy(box) for state, box in boxes.items() if state not in (source, target)]
        # An arrow and its reverse bow to different sides.
        sides = (1,) if (target, source) in pairs else (1, -1)
        costs = {}
        for bend in (side * bend for bend in BENDS for side in sides):
            points = curve(boxes[source], boxes[target], bend, 201)
            touched = sum(box.share(points) for box in others) + (1.0 - panel.share(points))
            costs[bend] = abs(bend) + 30.0 * touched
        chosen.append(min(costs, key=costs.__getitem__))
    return chosen


def _roomy(box: Box) -> Box:
    return Box(box.x, box.y, box.width + 4 * FREE_INCHES, box.height + 4 * FREE_INCHES)


COARSE = 4
"""Step between the points on an arrow that are tried as places for words."""

CLEAR = 0.02
"""Inches that words are kept away from arrows when they are placed by coarse points."""

BESIDE = (0.04, 0.1, 0.2, 0.4)
"""Inches between an arrow and its words, of which less is better."""


def place_words(
    sizes: Sequence[tuple[float, float]],
    curves: Sequence[Floats],
    states: Sequence[Box],
    width: float,
    height: float,
) -> list[Box]:
    """Return where the words of each arrow go: beside it, and where no other arrow crosses them.

    Args:
        sizes: width and height of the words of each arrow.
        curves: points on each arrow, shape (n, 2); arrows with words first.
        states: where the states are.
        width, height: of the panel around the origin.
    """
    every = np.array([curve[::COARSE] for curve in curves])
    found: dict[int, Box] = {}
    for i in sorted(range(len(sizes)), key=lambda i: -math.prod(sizes[i])):  # the largest first
        places = _candidates(sizes[i], curves[i])
        taken = [*states, *found.values()]
        costs = _costs(places, sizes[i], i, every, taken, width, height)
        x, y = places[int(costs.argmin())].tolist()
        found[i] = Box(x, y, *sizes[i])
    return [found[i] for i in range(len(sizes))]


ASTRAY = 0.25
"""Inches between an arrow and its words from where on the words seem to belong to nothing."""


def misplaced(
    places: Sequence[Box], states: Sequence[Box], curves: Sequence[Floats], inch: float = 1.0
) -> list[int]:
    """Return the words that cannot be read where they are, by the number of their arrow.

    They lie on a state or on earlier words, an arrow goes through them, or they are far from
    their own arrow, or nearer to another one.

    Args:
        places: of the words; those of arrows without words are left out, at the end.
        states: where the states are.
        curves: points on each arrow, shape (n, 2).
        inch: the unit of all lengths.
    """
    found = []
    for i, place in enumerate(places):
        middle, half = np.array([[place.x, place.y]]), np.array([place.width, place.height]) / 2
        away = _distances(middle, half, np.array(curves))[0]
        is_on_any = any(map(place.touches, (*states, *places[:i])))
        is_crossed = _crossings(middle, half[None], np.array(curves)).any()
        if is_on_any or is_crossed or away[i] > min(ASTRAY * inch, away.min()):
            found.append(i)
    return found


def _distances(places: Floats, half: Floats, curves: Floats) -> Floats:
    """Return how far arrows are from the edges of boxes, shape (places, arrows).

    The arguments are those of `_crossings`.
    """
    away = np.maximum(np.abs(curves[None] - places[:, None, None]) - half, 0.0)
    distances: Floats = np.hypot(away[..., 0], away[..., 1]).min(axis=2)
    return distances


def _crossings(places: Floats, half: Floats, curves: Floats) -> NDArray[np.bool_]:
    """Return whether boxes are crossed by arrows, shape (places, arrows).

    Each piece of an arrow is clipped to the box's slabs, as by Liang and Barsky.

    Args:
        places: middles of the boxes, shape (n, 2).
        half: half of their size, shape (1, 2).
        curves: points on the arrows, shape (m, k, 2).
    """
    begin = curves[None, :, :-1]
    step = curves[None, :, 1:] - begin
    step = np.where(np.abs(step) < 1e-9, 1e-9, step)
    middle = places[:, None, None]
    into, out = (middle - half - begin) / step, (middle + half - begin) / step
    first = np.minimum(into, out).max(axis=3)
    last = np.maximum(into, out).min(axis=3)
    crossed: NDArray[np.bool_] = (np.maximum(first, 0.0) <= np.minimum(last, 1.0)).any(axis=2)
    return crossed


def _candidates(size: tuple[float, float], points: Floats) -> Floats:
    """Return places, shape (n, 2), for words of this size beside an arrow."""
    n = len(points)
    inner = slice(n // 8, n - n // 8, 2)
    along = points[inner]
    direction = np.gradient(points, axis=0)[inner]
    normal = np.stack([direction[:, 1], -direction[:, 0]], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True) + 1e-12
    reach = (np.abs(normal) @ np.array(size))[:, None] / 2
    sides = [side * (reach + beside) for beside in BESIDE for side in (1.0, -1.0)]
    places: Floats = np.concatenate([along + side * normal for side in sides])
    return places


def _overlaps(places: Floats, size: tuple[float, float], other: Box) -> Floats:
    """Return how much words at each place, enlarged by the gap, overlap a box."""
    reach = np.array([size[0] + other.width, size[1] + other.height]) / 2 + FREE_INCHES
    common = reach - np.abs(places - (other.x, other.y))
    areas: Floats = np.prod(np.maximum(common, 0.0), axis=1)
    return areas


def _costs(
    places: Floats,
    size: tuple[float, float],
    own: int,
    curves: Floats,
    taken: Sequence[Box],
    width: float,
    height: float,
) -> Floats:
    """Return the cost of each place beside states and words that are placed already."""
    half = np.array(size) / 2
    crossed = _crossings(places, half[None] + CLEAR, curves).sum(axis=1)
    # How far each arrow is from the edge of the words: they belong to the nearest one.
    distances = _distances(places, half, curves)
    near = distances[:, own]
    others = np.delete(distances, own, axis=1)
    mistaken = np.maximum(near - others.min(axis=1), 0.0) if others.size else 0.0
    outside = np.maximum(np.abs(places) + half - (width / 2, height / 2), 0.0).sum(axis=1)
    middle = np.hypot(*(places - curves[own, curves.shape[1] // 2]).T)
    covered = [_overlaps(places, size, box) for box in taken]
    costs: Floats = (
        sum(60.0 * area + 10.0 * (area > 0.0) for area in covered)
        + 200.0 * outside
        + 10.0 * crossed
        + 6.0 * mistaken
        + 3.0 * near
        + 0.3 * middle
    )
    return costs


Measure = Callable[[str], tuple[float, float]]
"""Returns the width and height of a text as drawn."""


def state_boxes(
    order: Sequence[str], width: float, height: float, measure: Measure, margin: float = 0.0
) -> Mapping[str, Box]:
    """Return the box of each state in a panel of this size, sized to fit its name.

    ``margin`` is left free at both sides for words.
    """
    sizes = {state: measure(state) for state in order}
    widest = max(size[0] for size in sizes.values()) + 0.35
    tallest = max(size[1] for size in sizes.values()) + 0.3
    places = on_ellipse(len(order), width - max(widest, 2 * margin) - 0.3, height - tallest - 0.3)
    return {
        state: Box(x, y, sizes[state][0] + 0.3, tallest)
        for state, (x, y) in zip(order, places, strict=True)
    }
