"""Verb that trains from recorded actions, without commands: label."""

from __future__ import annotations

import re
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hitab_client import console
from hitab_client.terminal.cli_options import JsonPath
from hitab_core import named_domain, quantity

if TYPE_CHECKING:
    from rich.text import Text

    from hitab_core.labeling import Strip

_WAS = re.compile(r"([\d.]+)-([\d.]+)=(.+)")
_COLORS = ("blue", "green", "yellow", "magenta", "cyan", "red", "white", "bright_black")


def label(
    recording: Path,
    name: Annotated[str, typer.Argument(metavar="behavior")],
    feature: Annotated[list[str], typer.Option("--feature", "-f")],
    behavior: Annotated[list[str] | None, typer.Option("--behavior", "-b")] = None,
    was: Annotated[list[str] | None, typer.Option("--was", metavar="FROM-TO=BEHAVIOR")] = None,
    library: Annotated[Path | None, typer.Option("--library", "-l", metavar="FOLDER")] = None,
    agent: Annotated[str, typer.Option("--agent", "-a", show_default=False)] = "",
    json: JsonPath = None,
) -> None:
    """Label each moment of a recording with a behavior, and train from the labels.

    The recording may show an agent, a program in its place, or a person who drove. The strip shows
    the behavior of each span, how sure that is, and how many moments no behavior explains. Correct
    wrong labels with --was; with --library, train as if each change had been commanded.

    Args:
        recording: A file that `hitab record` or the studio wrote.
        name: Name of the behavior to train.
        feature: A feature for the decisions, such as "DistanceTo(ball)". Repeatable.
        behavior: A basic behavior that may be in the recording. Repeatable. Default: all
            that need no target.
        was: The behavior between two times, in s, such as 3.2-4.1=Stop. Repeatable.
        library: Train, and save in this folder: a library, or a new folder.
        agent: The recorded agent. Default: the only one.

    Examples:
      hitab library label session.mcap Chase -a keeper_1 -f "DistanceTo(ball)"
      hitab library label session.mcap Chase -a keeper_1 -f "DistanceTo(ball)" -b GoFast -b Stop
      --was 3.2-4.1=Stop -l trained
    """
    from hitab_client.recording import driving_of
    from hitab_core import BehaviorLibrary
    from hitab_core.labeling import Strip

    corrections = [_correction(text) for text in was or ()]
    console.note(f"reading {recording}")
    driven = driving_of(recording, agent)
    if driven.missing:
        console.note(driven.missing)
    domain = named_domain(driven.domain)
    request = driven.moments, domain, driven.agent, behavior or [], feature, corrections
    with console.progress("labeling", line_every=10_000) as advance:
        strip = Strip(*request, told=advance)
    spans = strip.spans
    console.note(
        f"{quantity(len(strip.moments), 'moment')} of {strip.agent} in {recording.name}: "
        f"{quantity(len(spans), 'span')}, {quantity(int(strip.unexplained.sum()), 'moment')} "
        "unexplained"
    )
    rows = [
        [
            f"{span.begin:.2f}",
            f"{span.end:.2f}",
            span.behavior,
            "corrected" if span.corrected else f"{100 * span.sure:.0f} %",
            str(span.unexplained or ""),
        ]
        for span in spans
    ]
    shown = console.table(["from", "to", "behavior", "sure", "unexplained"], rows)
    drawn = [_drawn(strip)] if console.out().is_terminal else []
    console.show(json, [asdict(span) for span in spans], *drawn, shown)
    if library is None:
        return
    saved = strip.train(name, BehaviorLibrary(library, domain), recording.name)
    for note in saved.notes:
        console.note(note)
    if json != "-":
        examples = quantity(len(saved.automaton.examples), "example")
        console.say(f"saved {name} with {examples} in {library}")


def _correction(text: str) -> tuple[float, float, str]:
    try:
        begin, end, behavior = _WAS.fullmatch(text).groups()  # type: ignore[union-attr]
        return float(begin), float(end), behavior
    except (AttributeError, ValueError):
        raise typer.BadParameter(
            f'"{text}" is not FROM-TO=BEHAVIOR, such as 3.2-4.1=Stop'
        ) from None


def _drawn(strip: Strip) -> Text:
    """Return the strip as one line of colors, with a legend."""
    from rich.text import Text

    width = min(console.out().width, len(strip.moments))
    line, styles = Text(), [f"black on {color}" for color in _COLORS]
    for cell in range(width):
        i = cell * len(strip.moments) // width
        sign = "?" if strip.unexplained[i] else " " if strip.is_sure(i) else "~"
        line.append(sign, styles[strip.labels[i] % len(styles)])
    line.append("\n")
    for which, behavior in enumerate(strip.behaviors):
        line.append(f" {behavior} ", styles[which % len(styles)])
    line.append("  ~ unsure  ? unexplained\n")
    return line
