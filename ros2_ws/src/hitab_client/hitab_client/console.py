"""What the command prints: messages and progress on stderr, results and JSON on stdout."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hitab_client.called_as import as_called
from hitab_core import HitabError
from hitab_core.library.durable_files import write_durably

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table


PIPED_WIDTH = 10_000
"""Columns, if the output is no terminal: then nothing has to fit."""


def out() -> Console:
    """Return a console for results: on a terminal they fit it, elsewhere lines are whole."""
    from rich.console import Console

    fitting = Console(highlight=False, emoji=False)
    if fitting.is_terminal:
        return fitting
    return Console(highlight=False, emoji=False, width=PIPED_WIDTH)


def table(columns: Sequence[str], rows: Iterable[Sequence[str]], title: str = "") -> Table:
    """Return a table; what does not fit the terminal is wrapped, never cut."""
    from rich.table import Table
    from rich.text import Text

    made = Table(box=None, pad_edge=False, title=title or None, title_justify="left")
    for column in columns:
        made.add_column(Text(column, overflow="fold"), overflow="fold")
    for row in rows:
        made.add_row(*(Text(cell, overflow="fold") for cell in row))
    return made


def err() -> Console:
    """Return a console for everything else."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, emoji=False)


def say(text: str) -> None:
    """Print a result in plain text."""
    print(as_called(text))


def note(text: str) -> None:
    """Print a message that is not a result."""
    print(as_called(text), file=sys.stderr)


def error(text: str) -> None:
    """Print an error."""
    err().print(f"[bold red]error:[/] {_escaped(as_called(text))}", soft_wrap=True)


def _escaped(text: str) -> str:
    from rich.markup import escape

    return escape(text)


def write_json(path: str | None, data: Any) -> None:
    """Write data as JSON to a file, or to stdout if the path is ``-``; do nothing if it is None.

    Raises:
        HitabError: if the file cannot be written.
    """
    if path is None:
        return
    text = json.dumps(data, indent=2, ensure_ascii=False) + "\n"
    if path == "-":
        sys.stdout.write(text)
        return
    file = Path(path)
    try:
        if file.is_file() or (not file.exists() and file.resolve().parent.is_dir()):
            write_durably(file.resolve(), text.encode())
        else:
            file.write_text(text, encoding="utf-8")  # such as /dev/null
    except OSError as wrong:
        raise HitabError(f"{path} cannot be written: {wrong.strerror}") from None


Advance = Callable[[int, int, str], None]
"""Called with the amount done, the total and the current activity."""


@contextmanager
def progress(description: str, unit: str = "") -> Iterator[Advance]:
    """Show a progress bar on stderr for the duration of the context, if it is a terminal."""
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        SpinnerColumn,
        TextColumn,
        TimeElapsedColumn,
    )

    console = err()
    bar = Progress(
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(bar_width=30),
        MofNCompleteColumn(),
        TextColumn(unit),
        TimeElapsedColumn(),
        TextColumn("[dim]{task.fields[doing]}"),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )
    with bar:
        task = bar.add_task(description, total=None, doing="")

        def advance(done: int, total: int, doing: str) -> None:
            bar.update(task, completed=done, total=total, doing=doing[:60])

        yield advance
