"""The verb `hitab grade`, which grades the exercises of a class."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hitab_client import console
from hitab_client.runs.shipped import find_file, shipped_names
from hitab_client.terminal.cli_options import JsonPath, SwarmName
from hitab_core import quantity


def register(app: typer.Typer) -> None:
    """Add `hitab grade`."""
    app.command(rich_help_panel="Train")(grade)


def grade(
    names: Annotated[list[str] | None, typer.Argument(metavar="EXERCISE")] = None,
    library: Annotated[str | None, typer.Option("--library", "-l", metavar="LIBRARY")] = None,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Grade exercises of a class by what is saved and by episodes.

    For each requirement it says whether it is met, and else what is missing. The swarm need not be
    up. The exit status is 1 if anything is missing.

    Args:
        names: Exercises, or their files. Default: all shipped exercises.
        library: Grade this library for all agents, such as one that was handed in. Default: those
            of the exercise's swarm.

    Examples:
      hitab grade chase
      hitab grade --swarm keepaway_ann
    """
    data = {
        name: _graded(name, find_file(name, "exercises", "exercise"), library, swarm)
        for name in names or sorted(shipped_names("exercises"))
    }
    console.write_json(json, data)
    if any(one["missing"] for grades in data.values() for one in grades):
        raise typer.Exit(1)


def _graded(name: str, path: Path, library: str | None, swarm: str | None) -> list[dict[str, str]]:
    """Grade an exercise and print the grades."""
    from hitab_bringup import named_library
    from hitab_class.exercises import Student, read_exercise
    from hitab_client.runs.run_folder import libraries_of, state_home

    exercise = read_exercise(path)
    libraries = libraries_of(state_home() / (swarm or exercise.swarm))
    if library is not None:
        libraries = dict.fromkeys(exercise.agents, named_library(library))
    grades = exercise.grade(Student(swarm or exercise.swarm, libraries))
    met = sum(not grade.missing for grade in grades)
    console.say(f"{name}: {met} of {quantity(len(grades), 'requirement')}")
    for grade in grades:
        console.say(f"  {'FAIL' if grade.missing else 'pass'}  {grade.requirement}")
        if grade.missing:
            console.say(f"        {grade.missing}")
    return [grade._asdict() for grade in grades]
