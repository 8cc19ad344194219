"""Figures that need no screen."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from hitab_core import HitabError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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
        HitabError: if that fails.
    """
    check_folder(path, "drawn")
    try:
        drawing.savefig(path)
    except (OSError, ValueError) as error:
        raise HitabError(f"{path} cannot be drawn: {error}") from None


def check_folder(path: Path, done: str) -> None:
    """Check that there is a folder for a file.

    Args:
        path: of the file.
        done: what is done to it, such as "drawn".

    Raises:
        HitabError: if there is none.
    """
    if not path.parent.is_dir():
        raise HitabError(
            f"{path} cannot be {done}: there is no folder {path.parent}; create it, or choose "
            "another file"
        )
