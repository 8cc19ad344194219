"""Figures drawn without a screen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING

from hitab_core import HitabError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLORS = ("#1f5fb4", "#d98c3f")


def figure(width: float, height: float) -> tuple[Figure, Axes]:
    """Return a figure of this size, in inches, with one pair of axes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    drawing = Figure(figsize=(width, height), dpi=130, layout="tight")
    FigureCanvasAgg(drawing)
    return drawing, drawing.add_subplot()


def save(drawing: Figure, path: Path) -> None:
    """Save a figure; the suffix selects the format.

    Raises:
        HitabError: if saving fails.
    """
    check_folder(path, "drawn")
    try:
        drawing.savefig(path)
    except (OSError, ValueError) as error:
        raise HitabError(f"{path} cannot be drawn: {error}") from None


def check_folder(path: Path, done: str) -> None:
    """Check that there is a folder for a file.

    Args:
        path: path of the file.
        done: participle for messages, such as "drawn".

    Raises:
        HitabError: if there is no folder.
    """
    if not path.parent.is_dir():
        raise HitabError(
            f"{path} cannot be {done}: there is no folder {path.parent}; create it, or choose "
            "another file"
        )


def draw_measures(
    measured: Mapping[str, Mapping[str, Sequence[float]]],
    title: str,
    path: Path,
    references: Mapping[str, float] | None = None,
) -> None:
    """Draw how measures of episodes are distributed, with their means, one below the other.

    Args:
        measured: values of each measure, by label of the measured swarm.
        title: title of the figure.
        path: path of the file.
        references: other means of the first measure, for comparison.

    Raises:
        HitabError: if the figure cannot be saved.
    """
    drawing, first = figure(7.0, 1.0 + 3.0 * len(measured))
    first.remove()
    drawing.suptitle(title, fontsize=10)
    for row, (measure, groups) in enumerate(measured.items(), 1):
        axes = drawing.add_subplot(len(measured), 1, row)
        axes.hist([*groups.values()], bins=30, color=COLORS[: len(groups)])
        for (name, values), color in zip(groups.items(), COLORS, strict=False):
            mean = fmean(values) if values else 0.0
            axes.axvline(mean, color=color, linewidth=2, label=f"{name}: mean {mean:.4g}")
        for name, mean in (references or {}).items() if row == 1 else ():
            axes.axvline(mean, color="black", linestyle="--", label=f"{name}: mean {mean:.4g}")
        axes.set_xlabel(measure)
        axes.set_ylabel("episodes")
        axes.legend()
    save(drawing, path)
