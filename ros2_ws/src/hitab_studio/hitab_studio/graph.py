"""Where to draw the states and arrows of an automaton on a page. Lengths are pixels."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from hitab_core import FLAGS, START, Automaton
from hitab_core.drawing.graph import Arrow, arrows
from hitab_core.drawing.layout import (
    Box,
    Floats,
    bend_arrows,
    crosses,
    curve,
    least_crossed,
    place_words,
    state_boxes,
)
from hitab_core.drawing.picture import words

INCH = 72.0
WIDTH = 392.0
LINE = 13.0
WRAP = 26
"""Characters in a line of a label."""

STRETCHES = (1.0, 1.4)
"""Heights that are tried, by the least one, for the one with room for most labels."""

FEW = 2
"""Rules listed below a drawing with which no other height is tried."""

TALLER = 3.0
"""Labels for which there has to be room so that a drawing may be twice as high."""


@dataclass(frozen=True)
class DrawnState:
    """A state: its center, size, name and kind."""

    name: str
    kind: str
    x: float
    y: float
    width: float
    height: float


@dataclass(frozen=True)
class DrawnArrow:
    """An arrow: its path, its label and where the label goes.

    Attributes:
        lines: of its label, or its number if there was no room for the label.
        number: under which its rule is listed below the drawing; 0 if it is drawn.
        rule: in one line.
    """

    source: str
    target: str
    path: str
    lines: tuple[str, ...]
    x: float
    y: float
    width: float
    height: float
    weak: bool
    number: int = 0
    rule: str = ""


@dataclass(frozen=True)
class Graph:
    """A drawing of an automaton."""

    width: float
    height: float
    states: tuple[DrawnState, ...]
    arrows: tuple[DrawnArrow, ...]


def _size(text: str, per_letter: float, line: float) -> tuple[float, float]:
    lines = text.split("\n")
    widest = max(len(part) for part in lines)
    return (widest * per_letter + 6) / INCH, (len(lines) * line + 2) / INCH


@lru_cache(maxsize=64)
def _graph(key: _ByIdentity, automata: frozenset[str]) -> Graph:
    automaton = key.automaton
    drawn = [arrow for arrow in arrows(automaton) if not arrow.is_loop]
    drawn.sort(key=lambda arrow: words(arrow) == "")
    texts = [_narrow(text) for arrow in drawn if (text := words(arrow))]
    lines = sum(text.count("\n") + 1 for text in texts)
    states = len(automaton.labels) + 1
    least = min(620.0, 150.0 + 34.0 * states + 7.0 * lines)
    found: list[tuple[int, float, _Layout, list[int]]] = []
    for stretch in STRETCHES:
        laid, numbered = _with_numbers(automaton, drawn, texts, least * stretch)
        found.append((len(numbered), stretch, laid, numbered))
        if len(numbered) <= FEW:
            break
    _, _, laid, numbered = min(found, key=lambda one: one[0] + TALLER * (one[1] - 1.0))
    return _drawn(laid, drawn, texts, numbered, automata)


def _with_numbers(
    automaton: Automaton, drawn: Sequence[Arrow], texts: Sequence[str], height: float
) -> tuple[_Layout, list[int]]:
    """Return a layout of this height, and the arrows whose rules are listed below the drawing."""
    numbered: list[int] = []
    while True:
        laid = _layout(automaton, drawn, texts, numbered, height)
        more = [i for i in _without_room(laid) if i not in numbered]
        if not more:
            return laid, numbered
        # The longest half first: then there may be room for the others.
        more.sort(key=lambda i: -laid.places[i].width * laid.places[i].height)
        numbered = sorted([*numbered, *more[: (len(more) + 1) // 2]])


@dataclass(frozen=True)
class _Layout:
    """Where everything goes; lengths in inches, around the middle."""

    height: float
    boxes: Mapping[str, Box]
    curves: Sequence[Floats]
    places: Sequence[Box]


def _narrow(text: str) -> str:
    """Wrap a label so that there is room for it beside the states."""
    return "\n".join(
        part
        for line in text.split("\n")
        for part in textwrap.wrap(line, WRAP, break_long_words=False) or [""]
    )


def _layout(
    automaton: Automaton,
    drawn: Sequence[Arrow],
    texts: Sequence[str],
    numbered: Sequence[int],
    height: float,
) -> _Layout:
    pairs = [(arrow.source, arrow.target) for arrow in drawn]
    states = least_crossed([START, *automaton.labels], pairs)
    sizes = [
        _size(str(numbered.index(i) + 1) if i in numbered else text, 5.9, LINE)
        for i, text in enumerate(texts)
    ]
    inches = WIDTH / INCH, height / INCH
    boxes = state_boxes(
        states,
        *inches,
        lambda text: _size(text, 6.6, 15.0),
        margin=0.42 * max((size[0] for size in sizes), default=0.0),
    )
    bends = bend_arrows(boxes, pairs, *inches)
    curves = [curve(boxes[s], boxes[t], b) for (s, t), b in zip(pairs, bends, strict=True)]
    return _Layout(height, boxes, curves, place_words(sizes, curves, [*boxes.values()], *inches))


def _without_room(laid: _Layout) -> list[int]:
    """Return the labels that lie on a state, an earlier label or an arrow, or outside."""
    half = WIDTH / INCH / 2, laid.height / INCH / 2
    found = []
    for i, place in enumerate(laid.places):
        others = [*laid.boxes.values(), *laid.places[:i]]
        outside = (
            abs(place.x) + place.width / 2 > half[0] or abs(place.y) + place.height / 2 > half[1]
        )
        crossed = any(crosses(points, place) for points in laid.curves)
        if outside or crossed or any(map(place.touches, others)):
            found.append(i)
    return found


def _drawn(
    laid: _Layout,
    drawn: Sequence[Arrow],
    texts: Sequence[str],
    numbered: Sequence[int],
    automata: frozenset[str],
) -> Graph:
    height, boxes = laid.height, laid.boxes

    def px(x: float, y: float) -> tuple[float, float]:
        return x * INCH + WIDTH / 2, height / 2 - y * INCH

    shown = []
    for i, (arrow, points) in enumerate(zip(drawn, laid.curves, strict=True)):
        outside = [p for p in points if not _inside(p, boxes[arrow.source], 2.0 / INCH)]
        outside = [p for p in outside if not _inside(p, boxes[arrow.target], 3.0 / INCH)]
        if len(outside) < 2:
            continue
        text = texts[i] if i < len(texts) else ""
        place = laid.places[i] if text else Box(0, 0, 0, 0)
        number = numbered.index(i) + 1 if i in numbered else 0
        x, y = px(place.x, place.y)
        shown.append(
            DrawnArrow(
                arrow.source,
                arrow.target,
                "M" + " L".join("{:.1f} {:.1f}".format(*px(*p)) for p in outside),
                (str(number),) if number else tuple(text.split("\n")) if text else (),
                x,
                y,
                place.width * INCH,
                place.height * INCH,
                arrow.leaves_flag,
                number,
                " ".join(text.split()),
            )
        )
    nodes = [
        DrawnState(
            name, _kind(name, automata), *px(box.x, box.y), box.width * INCH, box.height * INCH
        )
        for name, box in boxes.items()
    ]
    return Graph(WIDTH, height, tuple(nodes), tuple(shown))


class _ByIdentity:
    """Makes an automaton a key without looking into it."""

    def __init__(self, automaton: Automaton) -> None:
        self.automaton = automaton

    def __hash__(self) -> int:
        return id(self.automaton)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _ByIdentity) and other.automaton is self.automaton


def graph(automaton: Automaton, automata: Sequence[str]) -> Graph:
    """Return the drawing of an automaton.

    Args:
        automaton: to draw.
        automata: names of the behaviors that can be opened.
    """
    return _graph(_ByIdentity(automaton), frozenset(automata))


def _inside(point: np.ndarray[tuple[int], np.dtype[np.float64]], box: Box, margin: float) -> bool:
    return bool(
        abs(point[0] - box.x) <= box.width / 2 + margin
        and abs(point[1] - box.y) <= box.height / 2 + margin
    )


def _kind(state: str, automata: frozenset[str]) -> str:
    if state == START:
        return "start"
    if state in FLAGS:
        return "flag"
    return "automaton" if state.partition("(")[0] in automata else "basic"
