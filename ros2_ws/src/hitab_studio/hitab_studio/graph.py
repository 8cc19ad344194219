"""Where to draw the states and arrows of an automaton on a page. Lengths are pixels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from hitab_core import FLAGS, START, Automaton
from hitab_core.drawing.graph import arrows
from hitab_core.drawing.layout import (
    Box,
    bend_arrows,
    curve,
    least_crossed,
    place_words,
    state_boxes,
)
from hitab_core.drawing.picture import words

INCH = 72.0
WIDTH = 392.0
LINE = 13.0


@dataclass(frozen=True)
class DrawnState:
    """A state: its centre, size, name and kind."""

    name: str
    kind: str
    x: float
    y: float
    width: float
    height: float


@dataclass(frozen=True)
class DrawnArrow:
    """An arrow: its path, its label and where the label goes."""

    source: str
    target: str
    path: str
    lines: tuple[str, ...]
    x: float
    y: float
    width: float
    height: float
    weak: bool


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
    pairs = [(arrow.source, arrow.target) for arrow in drawn]
    states = least_crossed([START, *automaton.labels], pairs)
    texts = [text for arrow in drawn if (text := words(arrow))]
    sizes = [_size(text, 5.9, LINE) for text in texts]
    lines = sum(text.count("\n") + 1 for text in texts)
    height = min(620.0, 150.0 + 34.0 * len(states) + 7.0 * lines)
    inches = WIDTH / INCH, height / INCH
    boxes = state_boxes(
        states,
        *inches,
        lambda text: _size(text, 6.6, 15.0),
        margin=0.42 * max((size[0] for size in sizes), default=0.0),
    )
    bends = bend_arrows(boxes, pairs, *inches)
    curves = [curve(boxes[s], boxes[t], b) for (s, t), b in zip(pairs, bends, strict=True)]
    places = place_words(sizes, curves, [*boxes.values()], *inches)

    def px(x: float, y: float) -> tuple[float, float]:
        return x * INCH + WIDTH / 2, height / 2 - y * INCH

    shown = []
    for i, (arrow, points) in enumerate(zip(drawn, curves, strict=True)):
        outside = [p for p in points if not _inside(p, boxes[arrow.source], 2.0 / INCH)]
        outside = [p for p in outside if not _inside(p, boxes[arrow.target], 3.0 / INCH)]
        if len(outside) < 2:
            continue
        path = "M" + " L".join("{:.1f} {:.1f}".format(*px(*p)) for p in outside)
        text = words(arrow)
        place = places[i] if text else Box(0, 0, 0, 0)
        x, y = px(place.x, place.y)
        shown.append(
            DrawnArrow(
                arrow.source,
                arrow.target,
                path,
                tuple(text.split("\n")) if text else (),
                x,
                y,
                place.width * INCH,
                place.height * INCH,
                arrow.leaves_flag,
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
