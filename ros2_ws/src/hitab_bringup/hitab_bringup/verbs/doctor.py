"""The verb that looks for problems: doctor."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING

import typer

from hitab_client import console
from hitab_client.command_options import JsonPath

if TYPE_CHECKING:
    from hitab_bringup.doctor.finding import Finding

STYLES = {"ok": "green", "warning": "yellow", "error": "bold red"}


def doctor(json: JsonPath = None) -> None:
    """Check this computer, ROS, DDS, and what runs; name each problem and its remedy.

    The exit status is 1 if there is an error.

    Example:

      hitab doctor
    """
    from hitab_core import quantity

    found = []
    for finding in _findings():
        found.append(finding)
        if json != "-":
            _show(finding)
    counts = {level: sum(f.level == level for f in found) for level in STYLES}
    told = f"{quantity(counts['error'], 'error')}, {quantity(counts['warning'], 'warning')}"
    told = told if counts["error"] or counts["warning"] else "no problems found"
    console.show(json, [asdict(finding) for finding in found], told)
    if counts["error"]:
        raise typer.Exit(1)


def _findings() -> Iterator[Finding]:
    from hitab_bringup.doctor import machine, ros, runs
    from hitab_bringup.doctor.finding import ERROR, Finding
    from hitab_client.ros_environment import problems
    from hitab_core import HitabError

    yield from machine.python()
    # Where it cannot start, ROS may end the process that loads it.
    starts = [Finding(about, told, ERROR, way) for about, told, way in problems()] or [
        *ros.installation(),
        *ros.middleware(),
        *ros.domain(),
    ]
    yield from starts
    yield from runs.swarms()
    yield from runs.leftovers()
    if all(finding.level != "error" for finding in starts):
        try:
            yield from runs.faults()
        except HitabError as refused:
            yield Finding("ROS", str(refused), ERROR, "check the variables that begin with ROS_")
    yield from machine.home()
    yield from machine.memory()
    yield from machine.limits()


def _show(finding: Finding) -> None:
    shown = console.table(("", "", ""), ())
    shown.show_header, shown.padding = False, (0, 1, 0, 0)
    shown.columns[0].width, shown.columns[1].width = 7, 14
    level = console.line(finding.level, STYLES[finding.level])
    shown.add_row(level, console.line(finding.about), console.line(finding.text))
    if finding.way_out:
        shown.add_row("", "", console.line(finding.way_out))
    console.out().print(shown)
