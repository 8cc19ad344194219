"""Pictures of automata in the style of the paper's figure 1, as PNG, SVG or PDF.

matplotlib is imported on first use and needs no screen.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hitab_core.automaton import FLAGS, START, Automaton
from hitab_core.drawing.graph import Arrow, Way, arrows
from hitab_core.drawing.layout import (
    Box,
    bend_arrows,
    curve,
    least_crossed,
    place_words,
    state_boxes,
)
from hitab_core.errors import HitabError

_INK = "#1f2933"
_ARROW = "#52606d"
_FILL = {"start": "#1f2933", "flag": "#fde8c8", "automaton": "#d6e6f5", "basic": "#ffffff"}
_EDGE = {"start": "#1f2933", "flag": "#b7791f", "automaton": "#2b6cb0", "basic": "#52606d"}
_STATE_SIZE, _WORD_SIZE, _TITLE_SIZE = 10.0, 7.5, 13.0
_NUMBER = re.compile(r"(?<![\w.])-?\d+\.\d+(?:e[-+]?\d+)?(?![\w.])")
_WRAP = 48


def draw_automaton(automaton: Automaton, path: Path | str) -> Path:
    """Draw one automaton into a file; see `draw_automata`."""
    return draw_automata([automaton], path)


def draw_automata(automata: Sequence[Automaton], path: Path | str) -> Path:
    """Draw automata side by side into a file.

    A state is a rounded box: blue if it is one of the other automata drawn, amber if it is a
    flag, dark if it is Start. Arrows carry the rules under which they are taken. Staying is left
    out; the arrow from a flag back to Start, which is always taken, is dashed.

    Args:
        automata: one panel each.
        path: the file; its suffix selects the format, such as ``.png`` or ``.svg``.

    Returns:
        The file.

    Raises:
        HitabError: if there is nothing to draw, or matplotlib is missing or cannot write the file.
    """
    path = Path(path)
    if not automata:
        raise HitabError(f"{path}: there is no automaton to draw")
    try:
        from matplotlib import rc_context
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise HitabError("pictures need matplotlib, which is not installed; install it") from None
    sizes = [_panel_size(automaton) for automaton in automata]
    columns = math.ceil(math.sqrt(len(automata)))
    rows = [range(i, min(i + columns, len(automata))) for i in range(0, len(automata), columns)]
    widths = [max(sizes[i][0] for i in range(c, len(automata), columns)) for c in range(columns)]
    heights = [max(sizes[i][1] for i in row) for row in rows]
    figure = Figure(figsize=(sum(widths), sum(heights)), facecolor="white")
    canvas = FigureCanvasAgg(figure)
    grid = figure.add_gridspec(
        len(rows),
        columns,
        width_ratios=widths,
        height_ratios=heights,
        left=0,
        right=1,
        top=1,
        bottom=0,
        wspace=0,
        hspace=0,
    )
    names = {automaton.name for automaton in automata}
    for r, row in enumerate(rows):
        for c, i in enumerate(row):
            axes = figure.add_subplot(grid[r, c])
            _Panel(axes, canvas, widths[c], heights[r]).draw(automata[i], names)
    stable = {"Date": None} if path.suffix == ".svg" else None
    try:
        with rc_context({"svg.hashsalt": "hitab", "svg.fonttype": "none"}):
            figure.savefig(path, dpi=150, metadata=stable)
    except (OSError, ValueError) as error:
        raise HitabError(f"{path}: cannot be drawn: {error}") from error
    return path


def words(arrow: Arrow) -> str:
    """Return the label of an arrow: its ways, wrapped to be readable in a picture."""
    if arrow.leaves_flag:
        return ""
    return "\nor ".join(_wrapped(way) for way in arrow.ways)


def _wrapped(way: Way) -> str:
    if not way.conditions and way.probability == 1.0:
        return ""
    lines: list[str] = []
    for condition in way.conditions:
        short = _NUMBER.sub(lambda number: f"{float(number.group()):.4g}", condition)
        short = short.replace("<=", "≤").replace(">=", "≥")
        and_ = "and " if lines else ""
        lines += textwrap.wrap(and_ + short, _WRAP, break_long_words=False)
    text = "\n".join(lines)
    if way.probability < 1.0:
        text = f"{text}\n" if text else ""
        text += f"p = {way.probability:.2g}"
    return text


def _panel_size(automaton: Automaton) -> tuple[float, float]:
    """Return the width and height of a panel that has room for all its labels."""
    texts = [words(arrow) for arrow in arrows(automaton) if not arrow.is_loop]
    lines = sum(text.count("\n") + 1 for text in texts if text)
    side = 3.2 + 0.28 * (len(automaton.states) + 1) + 0.075 * lines
    longest = max((len(line) for text in texts for line in text.split("\n")), default=0)
    return (1.3 * side + 0.02 * longest, side)


class _Panel:
    """One automaton on axes in inches, with the origin in the middle."""

    def __init__(self, axes: Any, canvas: Any, width: float, height: float) -> None:
        self._axes = axes
        self._renderer = canvas.get_renderer()
        self._width, self._height = width, height - 0.5  # the title is above
        axes.set_xlim(-width / 2, width / 2)
        axes.set_ylim(-self._height / 2, height - self._height / 2)
        axes.set_axis_off()

    def draw(self, automaton: Automaton, drawn_too: set[str]) -> None:
        drawn = [arrow for arrow in arrows(automaton) if not arrow.is_loop]
        drawn.sort(key=lambda arrow: words(arrow) == "")
        states = least_crossed(
            [START, *automaton.labels], [(arrow.source, arrow.target) for arrow in drawn]
        )
        texts = [text for arrow in drawn if (text := words(arrow))]
        sizes = [self._size(text, _WORD_SIZE) for text in texts]
        boxes = state_boxes(
            states,
            self._width,
            self._height,
            lambda text: self._size(text, _STATE_SIZE),
            margin=0.6 * max((size[0] for size in sizes), default=0.0),
        )
        title = automaton.name
        if automaton.parameters:
            title += f"({', '.join(automaton.parameters)})"
        self._axes.text(
            0,
            self._height / 2 + 0.22,
            title,
            ha="center",
            va="center",
            color=_INK,
            fontsize=_TITLE_SIZE,
            fontweight="bold",
        )
        outlines = {state: self._state(state, boxes[state], drawn_too) for state in states}
        pairs = [(arrow.source, arrow.target) for arrow in drawn]
        bends = bend_arrows(boxes, pairs, self._width, self._height)
        curves = [curve(boxes[s], boxes[t], b) for (s, t), b in zip(pairs, bends, strict=True)]
        places = place_words(sizes, curves, [*boxes.values()], self._width, self._height)
        for arrow, bend in zip(drawn, bends, strict=True):
            self._arrow(arrow, bend, boxes, outlines)
        for text, place in zip(texts, places, strict=True):
            self._axes.text(
                place.x,
                place.y,
                text,
                ha="center",
                va="center",
                fontsize=_WORD_SIZE,
                color=_INK,
                zorder=4,
                linespacing=1.1,
                bbox={"boxstyle": "round,pad=0.12", "fc": "white", "ec": "none", "alpha": 0.88},
            )

    def _size(self, text: str, size: float) -> tuple[float, float]:
        shown = self._axes.text(0, 0, text, fontsize=size, linespacing=1.1)
        extent = shown.get_window_extent(self._renderer)
        shown.remove()
        dpi = self._axes.figure.dpi
        return extent.width / dpi + 0.05, extent.height / dpi + 0.05

    def _state(self, state: str, box: Box, drawn_too: set[str]) -> Any:
        from matplotlib.patches import FancyBboxPatch

        kind = _kind(state, drawn_too)
        outline = FancyBboxPatch(
            (box.x - box.width / 2, box.y - box.height / 2),
            box.width,
            box.height,
            boxstyle=f"round,pad=0,rounding_size={box.height / 2 if kind == 'flag' else 0.12}",
            fc=_FILL[kind],
            ec=_EDGE[kind],
            lw=1.4,
            zorder=3,
            linestyle="--" if kind == "flag" else "-",
        )
        self._axes.add_patch(outline)
        self._axes.text(
            box.x,
            box.y,
            state,
            ha="center",
            va="center_baseline",
            fontsize=_STATE_SIZE,
            color="white" if kind == "start" else _INK,
            zorder=5,
            fontstyle="italic" if kind == "flag" else "normal",
        )
        return outline

    def _arrow(self, arrow: Arrow, bend: float, boxes: Any, outlines: Any) -> None:
        from matplotlib.patches import FancyArrowPatch

        start, end = boxes[arrow.source], boxes[arrow.target]
        self._axes.add_patch(
            FancyArrowPatch(
                (start.x, start.y),
                (end.x, end.y),
                connectionstyle=f"arc3,rad={bend}",
                patchA=outlines[arrow.source],
                patchB=outlines[arrow.target],
                arrowstyle="-|>",
                mutation_scale=12,
                lw=1.1,
                color=_ARROW,
                zorder=2,
                linestyle=(0, (4, 3)) if arrow.leaves_flag else "-",
                shrinkA=0,
                shrinkB=1,
            )
        )


def _kind(state: str, drawn_too: set[str]) -> str:
    if state == START:
        return "start"
    if state in FLAGS:
        return "flag"
    return "automaton" if state.partition("(")[0] in drawn_too else "basic"
