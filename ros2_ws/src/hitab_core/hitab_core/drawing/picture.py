"""Pictures of automata in the style of the paper's figure 1, as PNG, SVG or PDF.

matplotlib is imported on first use and needs no screen.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hitab_core.automaton import FLAGS, START, Automaton
from hitab_core.drawing.graph import Arrow, Way, arrows
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
from hitab_core.texts.errors import HitabError
from hitab_core.texts.wording import unbroken

_INK = "#1f2933"
_ARROW = "#52606d"
_FILL = {"start": "#1f2933", "flag": "#fde8c8", "automaton": "#d6e6f5", "basic": "#ffffff"}
_EDGE = {"start": "#1f2933", "flag": "#b7791f", "automaton": "#2b6cb0", "basic": "#52606d"}
_STATE_SIZE, _WORD_SIZE, _TITLE_SIZE = 10.0, 7.5, 13.0
_NUMBER = re.compile(r"(?<![\w.])-?\d+\.\d+(?:e[-+]?\d+)?(?![\w.])")
_WRAP = 48


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
    measure = text_sizes()
    panels = [lay_out(automaton, measure) for automaton in automata]
    sizes = [(panel.width, panel.height) for panel in panels]
    columns = math.ceil(math.sqrt(len(automata)))
    rows = [range(i, min(i + columns, len(automata))) for i in range(0, len(automata), columns)]
    widths = [max(sizes[i][0] for i in range(c, len(automata), columns)) for c in range(columns)]
    heights = [max(sizes[i][1] for i in row) for row in rows]
    figure = Figure(figsize=(sum(widths), sum(heights)), facecolor="white")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(len(rows), columns, width_ratios=widths, height_ratios=heights)
    grid.update(left=0, right=1, top=1, bottom=0, wspace=0, hspace=0)
    names = {automaton.name for automaton in automata}
    for r, row in enumerate(rows):
        for c, i in enumerate(row):
            axes = figure.add_subplot(grid[r, c])
            _Panel(axes, widths[c], heights[r]).draw(panels[i], names)
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
        lines += textwrap.wrap(and_ + unbroken(short), _WRAP, break_long_words=False)
    text = "\n".join(lines)
    if way.probability < 1.0:
        text = f"{text}\n" if text else ""
        text += f"p = {way.probability:.2g}"
    return text


Measure = Callable[[str, float], tuple[float, float]]
"""Returns the width and height of a text in a font size, in inches."""

GROWTH = (1.0, 1.15, 1.3, 1.5, 1.75)
"""Sizes of a panel that are tried, until nothing lies on anything else."""

_TITLE_HEIGHT = 0.5


@dataclass(frozen=True)
class AutomatonPanel:
    """Places of all parts of one drawn automaton; lengths in inches, around the middle.

    Attributes:
        width, height: with the title above.
        states: the boxes of the states.
        arrows: those that are drawn, those with words first.
        bends: of the arrows.
        curves: points on the arrows.
        words: of the first arrows, one text each.
        places: of the words.
    """

    automaton: Automaton
    width: float
    height: float
    states: Mapping[str, Box]
    arrows: Sequence[Arrow]
    bends: Sequence[float]
    curves: Sequence[Floats]
    words: Sequence[str]
    places: Sequence[Box]

    @property
    def collisions(self) -> int:
        """Number of words that cannot be read where they are, see `misplaced`."""
        return len(misplaced(self.places, [*self.states.values()], self.curves))


def lay_out(automaton: Automaton, measure: Measure) -> AutomatonPanel:
    """Return where to draw an automaton, in a panel with room for all its words."""
    tried = []
    for growth in GROWTH:
        tried.append(_laid(automaton, measure, growth))
        if not tried[-1].collisions:
            break
    return min(tried, key=lambda panel: panel.collisions)


def _laid(automaton: Automaton, measure: Measure, growth: float) -> AutomatonPanel:
    drawn = [arrow for arrow in arrows(automaton) if not arrow.is_loop]
    drawn.sort(key=lambda arrow: words(arrow) == "")
    texts = [text for arrow in drawn if (text := words(arrow))]
    lines = sum(text.count("\n") + 1 for text in texts)
    side = 3.2 + 0.28 * (len(automaton.states) + 1) + 0.075 * lines
    longest = max((len(line) for text in texts for line in text.split("\n")), default=0)
    width, height = growth * (1.3 * side + 0.02 * longest), growth * side
    pairs = [(arrow.source, arrow.target) for arrow in drawn]
    sizes = [measure(text, _WORD_SIZE) for text in texts]
    inner = height - _TITLE_HEIGHT
    boxes = state_boxes(
        least_crossed([START, *automaton.labels], pairs),
        width,
        inner,
        lambda text: measure(text, _STATE_SIZE),
        margin=0.6 * max((size[0] for size in sizes), default=0.0),
    )
    bends = bend_arrows(boxes, pairs, width, inner)
    curves = [curve(boxes[s], boxes[t], b) for (s, t), b in zip(pairs, bends, strict=True)]
    places = place_words(sizes, curves, [*boxes.values()], width, inner)
    return AutomatonPanel(automaton, width, height, boxes, drawn, bends, curves, texts, places)


def text_sizes() -> Measure:
    """Return what measures texts as they are drawn."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(1.0, 1.0))
    canvas: Any = FigureCanvasAgg(figure)
    renderer = canvas.get_renderer()

    def measure(text: str, size: float) -> tuple[float, float]:
        shown = figure.text(0, 0, text, fontsize=size, linespacing=1.1)
        extent = shown.get_window_extent(renderer)
        shown.remove()
        return extent.width / figure.dpi + 0.05, extent.height / figure.dpi + 0.05

    return measure


class _Panel:
    """Draws one automaton on axes in inches, with the origin in the middle."""

    def __init__(self, axes: Any, width: float, height: float) -> None:
        self._axes = axes
        self._height = height - _TITLE_HEIGHT  # the title is above
        axes.set_xlim(-width / 2, width / 2)
        axes.set_ylim(-self._height / 2, height - self._height / 2)
        axes.set_axis_off()

    def draw(self, panel: AutomatonPanel, drawn_too: set[str]) -> None:
        title = panel.automaton.name
        if panel.automaton.parameters:
            title += f"({', '.join(panel.automaton.parameters)})"
        self._write(0, self._height / 2 + 0.22, title, _TITLE_SIZE, fontweight="bold")
        outlines = {name: self._state(name, box, drawn_too) for name, box in panel.states.items()}
        for arrow, bend in zip(panel.arrows, panel.bends, strict=True):
            self._arrow(arrow, bend, panel.states, outlines)
        for text, place in zip(panel.words, panel.places, strict=True):
            self._write(place.x, place.y, text, _WORD_SIZE, zorder=4, linespacing=1.1)

    def _write(self, x: float, y: float, text: str, size: float, **style: Any) -> None:
        usual = {"ha": "center", "va": "center", "color": _INK, "fontsize": size}
        self._axes.text(x, y, text, **usual | style)

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
        style = {"fontstyle": "italic"} if kind == "flag" else {}
        if kind == "start":
            style = {"color": "white"}
        self._write(box.x, box.y, state, _STATE_SIZE, va="center_baseline", zorder=5, **style)
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
