"""Output of the command: messages and progress on stderr, results and JSON on stdout."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hitab_client.terminal.cli_remedies import with_commands
from hitab_core import HitabError
from hitab_ros.timing import REPEAT_S

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text


PIPED_WIDTH = 10_000
"""Width in columns if the output is not a terminal, where nothing has to fit."""


def out() -> Console:
    """Return a console for results; lines are wrapped only on a terminal."""
    from rich.console import Console

    fitting = Console(highlight=False, emoji=False)
    if fitting.is_terminal:
        return fitting
    return Console(highlight=False, emoji=False, width=PIPED_WIDTH)


@contextmanager
def live(shown: Any) -> Iterator[Callable[[Any], None]]:
    """Show something, and yield a function that updates it; a pipe gets only the last state.

    A terminal that cannot move its cursor, according to TERM, gets each state below the last.
    """
    from rich.live import Live

    screen, last, due = out(), "", 0.0

    def show_below(state: Any) -> None:
        nonlocal last, due
        with screen.capture() as captured:
            screen.print(state)
        if captured.get() != last and time.monotonic() >= due:
            last, due = captured.get(), time.monotonic() + REPEAT_S
            say(last.rstrip("\n"))

    if screen.is_dumb_terminal:
        show_below(shown)
        yield show_below
    else:
        with Live(shown, console=screen) as kept:
            yield kept.update


def line(text: str, style: str = "") -> Text:
    """Return a line for a table, a tree or a group, without markup.

    A line that does not fit the terminal is wrapped.
    """
    from rich.text import Text

    return Text(text, style=style, overflow="fold")


def table(columns: Sequence[str], rows: Iterable[Sequence[str]], title: str = "") -> Table:
    """Return a table; text that does not fit the terminal is wrapped, never cut."""
    from rich.table import Table

    made = Table(box=None, pad_edge=False, title=title or None, title_justify="left")
    for column in columns:
        made.add_column(line(column), overflow="fold")
    for row in rows:
        made.add_row(*(line(cell) for cell in row))
    return made


def err() -> Console:
    """Return a console for messages and progress, on stderr."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, emoji=False)


def say(text: str) -> None:
    """Print a result in plain text, flushed at once."""
    print(text, flush=True)


def note(text: str) -> None:
    """Print a message that is not a result."""
    print(text, file=sys.stderr)


def error(wrong: str | HitabError) -> None:
    """Print an error and, below it, its remedies."""
    from rich.markup import escape

    if isinstance(wrong, HitabError):
        wrong = with_commands(wrong.problem, wrong.remedies)
    err().print(f"[bold red]error:[/] {escape(wrong)}", soft_wrap=True)


def say_answer(answer: Any, text: str = "") -> None:
    """Print a service's answer, or another text, and below it the next steps."""
    from hitab_ros.messages.conversions import (
        remedies_of,  # here because the help imports this module
    )

    say(with_commands(text or answer.message, remedies_of(answer.remedies)))


def show(json: str | None, data: Any, *shown: Any) -> None:
    """Print a result, unless its JSON goes to stdout, and write the JSON if requested.

    Args:
        json: path of the JSON, see `write_json`.
        data: content of the JSON.
        shown: lines, tables or trees.
    """
    if json != "-":
        for one in shown:
            if isinstance(one, str):
                say(one)
            else:
                out().print(one)
    write_json(json, data)


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
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError as wrong:
        raise HitabError(f"{path} cannot be written: {wrong.strerror}") from None


Advance = Callable[[int, int, str], None]
"""Called with the amount done, the total and the current activity."""


@contextmanager
def progress(description: str, unit: str = "", *, line_every: int = 0) -> Iterator[Advance]:
    """Show a progress bar on stderr for the duration of the context, if it is a terminal.

    Args:
        description: text beside the bar.
        unit: unit of the amounts.
        line_every: amount after which another line is printed if stderr is not a terminal; 0
            for no lines.
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
        redirect_stdout=sys.stdout.isatty(),  # other output stays above the bar
        disable=not console.is_terminal or console.is_dumb_terminal,
    )
    with bar:
        task = bar.add_task(description, total=None, doing="")
        lines_printed = 0

        def advance(done: int, total: int, doing: str) -> None:
            nonlocal lines_printed
            bar.update(task, completed=done, total=total, doing=doing[:60])
            if bar.disable and line_every and done // line_every > lines_printed:
                lines_printed = done // line_every
                note(f"{description}: {done} of {total} {unit}")

        yield advance
