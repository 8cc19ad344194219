"""Layout of an automaton's states and arrows on a page. Lengths are pixels."""

from __future__ import annotations

import textwrap
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import lru_cache

from hitab_core import FLAGS, START, Automaton
from hitab_core.drawing.graph import Arrow, arrows
from hitab_core.drawing.layout import (
    Box,
    Floats,
    bend_arrows,
    curve,
    least_crossed,
    misplaced,
    place_words,
    state_boxes,
)
from hitab_core.drawing.picture import words

INCH = 72.0  # unit of length of `hitab_core.drawing`
WIDTH = 392.0
LINE = 13.0
LABEL_WIDTH = 26
"""Maximum characters in a line of a label."""

ARROW_GAP = 2.0
"""The gap between a state and an arrow."""


@dataclass(frozen=True)
class DrawnArrow:
    """An arrow, ready to be drawn.

    Attributes:
        path: SVG path of the arrow.
        lines: lines of the label, or the rule's number if there is no room for the label.
        place: box of the label.
        number: number of the rule in the list below the drawing; 0 if not listed.
    """

    arrow: Arrow
    path: str
    lines: tuple[str, ...]
    place: Box
    number: int


@dataclass(frozen=True)
class Graph:
    """A drawing of an automaton: its states, each with its kind and place, and arrows."""

    width: float
    height: float
    states: tuple[tuple[str, str, Box], ...]
    arrows: tuple[DrawnArrow, ...]


def graph(automaton: Automaton, automata: Collection[str]) -> Graph:
    """Return the drawing of an automaton.

    Args:
        automaton: the automaton to draw.
        automata: names of the behaviors that can be opened.
    """
    return _graph(_ByIdentity(automaton), frozenset(automata))


class _ByIdentity:
    """Wraps an automaton as a cache key that is compared by identity."""

    def __init__(self, automaton: Automaton) -> None:
        self.automaton = automaton

    def __hash__(self) -> int:
        return id(self.automaton)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _ByIdentity) and other.automaton is self.automaton


@lru_cache(maxsize=64)
def _graph(key: _ByIdentity, automata: frozenset[str]) -> Graph:
    """Lay out the automaton, replacing labels by numbers until all of them have room."""
    automaton = key.automaton
    drawn = [arrow for arrow in arrows(automaton) if not arrow.is_loop]
    drawn.sort(key=lambda arrow: words(arrow) == "")
    texts = [_narrow(text) for arrow in drawn if (text := words(arrow))]
    lines = sum(text.count("\n") + 1 for text in texts)
    height = min(620.0, 150.0 + 34.0 * (len(automaton.labels) + 1) + 7.0 * lines)
    states = [START, *automaton.labels]
    numbers: dict[int, int] = {}
    while True:
        labels = [str(numbers[i]) if i in numbers else text for i, text in enumerate(texts)]
        boxes, curves, places = layout = _layout(states, drawn, labels, height)
        crowded = [i for i in _misplaced_labels(layout, height) if i not in numbers]
        if not crowded:
            break
        crowded.sort(key=lambda i: len(texts[i]))  # the longest first: then others may have room
        numbered = sorted([*numbers, *crowded[len(crowded) // 2 :]])
        numbers = {i: number for number, i in enumerate(numbered, 1)}
    shown = []
    for i, (arrow, points) in enumerate(zip(drawn, curves, strict=True)):
        outside = [
            p for p in points if not any(_in(p, boxes[s]) for s in (arrow.source, arrow.target))
        ]
        shown.append(
            DrawnArrow(
                arrow,
                "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in outside) if outside else "",
                tuple(labels[i].split("\n")) if i < len(labels) else (),
                places[i] if i < len(labels) else Box(0.0, 0.0, 0.0, 0.0),
                numbers.get(i, 0),
            )
        )
    nodes = tuple((name, _kind(name, automata), box) for name, box in boxes.items())
    return Graph(WIDTH, height, nodes, tuple(shown))


def _narrow(text: str) -> str:
    """Wrap a label so that it fits beside the states."""
    lines = text.split("\n")
    return "\n".join(part for line in lines for part in textwrap.wrap(line, LABEL_WIDTH) or [""])


def _size(text: str, per_letter: float, line: float) -> tuple[float, float]:
    lines = text.split("\n")
    widest = max(len(part) for part in lines)
    return (widest * per_letter + 6) / INCH, (len(lines) * line + 2) / INCH


Layout = tuple[dict[str, Box], list[Floats], list[Box]]
"""The states, the points of the arrows, and the places of the labels."""


def _layout(
    states: Sequence[str], drawn: Sequence[Arrow], labels: Sequence[str], height: float
) -> Layout:
    pairs = [(arrow.source, arrow.target) for arrow in drawn]
    sizes = [_size(label, 5.9, LINE) for label in labels]
    inches = WIDTH / INCH, height / INCH
    boxes = state_boxes(
        least_crossed(states, pairs),
        *inches,
        lambda text: _size(text, 6.6, 15.0),
        margin=0.42 * max((size[0] for size in sizes), default=0.0),
    )
    bends = bend_arrows(boxes, pairs, *inches)
    curves = [curve(boxes[s], boxes[t], b) for (s, t), b in zip(pairs, bends, strict=True)]
    places = place_words(sizes, curves, [*boxes.values()], *inches)
    return (
        {name: _pixels(box, height) for name, box in boxes.items()},
        [points * (INCH, -INCH) + (WIDTH / 2, height / 2) for points in curves],
        [_pixels(place, height) for place in places],
    )


def _pixels(box: Box, height: float) -> Box:
    x, y = WIDTH / 2 + box.x * INCH, height / 2 - box.y * INCH
    return Box(x, y, box.width * INCH, box.height * INCH)


def _misplaced_labels(layout: Layout, height: float) -> list[int]:
    """Return the labels outside the drawing or illegible, see `misplaced`."""
    boxes, curves, places = layout
    outside = {
        i
        for i, place in enumerate(places)
        if abs(place.x - WIDTH / 2) + place.width / 2 > WIDTH / 2
        or abs(place.y - height / 2) + place.height / 2 > height / 2
    }
    return sorted(outside.union(misplaced(places, [*boxes.values()], curves, INCH)))


def _in(point: Floats, box: Box) -> bool:
    x, y = point
    return bool(
        abs(x - box.x) <= box.width / 2 + ARROW_GAP
        and abs(y - box.y) <= box.height / 2 + ARROW_GAP
    )


def _kind(state: str, automata: Collection[str]) -> str:
    if state == START:
        return "start"
    if state in FLAGS:
        return "flag"
    return "automaton" if state.partition("(")[0] in automata else "basic"
