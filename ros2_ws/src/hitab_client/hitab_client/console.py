"""What the command prints: messages and progress on stderr, results and JSON on stdout."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hitab_client.commands import with_commands
from hitab_core import HitabError
from hitab_core.library.durable_files import write_durably

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult
    from rich.table import Table
    from rich.text import Text


PIPED_WIDTH = 10_000
"""Columns, if the output is no terminal: then nothing has to fit."""


def out() -> Console:
    """Return a console for results: on a terminal they fit it, elsewhere lines are whole."""
    from rich.console import Console

    fitting = Console(highlight=False, emoji=False)
    if fitting.is_terminal:
        return fitting
    return Console(highlight=False, emoji=False, width=PIPED_WIDTH)


@contextmanager
def live(shown: Any) -> Iterator[Callable[[Any], None]]:
    """Keep something up to date on stdout; in a pipe or a file, its last state is printed.

    Args:
        shown: at the beginning. The context's value is called with each later state.
    """
    from rich.live import Live

    console = out()
    if console.is_terminal:
        with Live(shown, console=console, screen=False) as live:
            yield live.update
        return
    last = shown

    def update(later: Any) -> None:
        nonlocal last
        last = later

    try:
        yield update
    finally:
        console.print(last)


def line(text: str, style: str = "") -> Text:
    """Return a line for a table, a tree or a group, to be shown as it is.

    What does not fit the terminal is wrapped.
    """
    from rich.text import Text

    return Text(text, style=style, overflow="fold")


def table(columns: Sequence[str], rows: Iterable[Sequence[str]], title: str = "") -> Table:
    """Return a table; what does not fit the terminal is wrapped, never cut.

    Its lines end with their last word.
    """
    made = _trimmed_table()(box=None, pad_edge=False, title=title or None, title_justify="left")
    for column in columns:
        made.add_column(line(column), overflow="fold")
    for row in rows:
        made.add_row(*(line(cell) for cell in row))
    return made


@cache
def _trimmed_table() -> type[Table]:
    """Return a kind of table whose lines are not filled up with spaces."""
    from rich.segment import Segment
    from rich.table import Table

    class TrimmedTable(Table):
        def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
            for line in Segment.split_lines(super().__rich_console__(console, options)):  # type: ignore[arg-type]
                while line and not line[-1].control and not line[-1].text.strip():
                    line.pop()
                if line and not line[-1].control:
                    text, style, _ = line[-1]
                    line[-1] = Segment(text.rstrip(), style)
                yield from line
                yield Segment.line()

    return TrimmedTable


def err() -> Console:
    """Return a console for everything else."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, emoji=False)


def say(text: str) -> None:
    """Print a result in plain text, at once also into a pipe or a file."""
    print(text, flush=True)


def note(text: str) -> None:
    """Print a message that is not a result."""
    print(text, file=sys.stderr)


def error(wrong: str | HitabError) -> None:
    """Print an error: what is wrong, and below it what to do."""
    if isinstance(wrong, HitabError):
        wrong = with_commands(wrong.problem, wrong.remedies)
    err().print(f"[bold red]error:[/] {_escaped(wrong)}", soft_wrap=True)


def say_answer(answer: Any, text: str = "") -> None:
    """Print what a service has done, or another text, and below it what can be done next."""
    from hitab_ros.conversions import remedies_of  # here because the help imports this module

    say(with_commands(text or answer.message, remedies_of(answer.remedies)))


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
def progress(description: str, unit: str = "", *, line_every: int = 0) -> Iterator[Advance]:
    """Show a progress bar on stderr for the duration of the context, if it is a terminal.

    Args:
        description: what is going on.
        unit: of the amounts.
        line_every: elsewhere than on a terminal, print a line whenever so much more is done; 0:
            none.
    """
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
        told = 0

        def advance(done: int, total: int, doing: str) -> None:
            nonlocal told
            bar.update(task, completed=done, total=total, doing=doing[:60])
            if bar.disable and line_every and done // line_every > told:
                told = done // line_every
                note(f"{description}: {done} of {total} {unit}")

        yield advance
