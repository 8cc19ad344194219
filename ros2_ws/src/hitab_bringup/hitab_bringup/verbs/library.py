"""Verbs for libraries of trained behaviors: list, show, check, diff, and those that change."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from hitab_bringup.verbs import library_changes, recording
from hitab_bringup.verbs.library_options import (
    Agent,
    Library,
    Name,
    chosen_folders,
    chosen_libraries,
    opened,
)
from hitab_client import console
from hitab_client.command_options import JsonPath, SwarmName
from hitab_core import quantity

app = typer.Typer(help="Inspect and change libraries of trained behaviors.")


@app.command("list")
def list_behaviors(
    library: Library = None, agent: Agent = None, swarm: SwarmName = None, json: JsonPath = None
) -> None:
    """List the behaviors of a library, or of all libraries of the swarm that is up.

    Examples:

      hitab library list -l hitab-demo/library

      hitab library list --agent keeper_1
    """
    from hitab_bringup.library_choice import holds_behaviors
    from hitab_bringup.opened_library import open_library
    from hitab_core import Do, LibraryError, some

    libraries = chosen_libraries(library, agent, swarm)
    different = len(libraries) > 1
    found: dict[tuple[str, str], dict[str, Any]] = {}
    without: list[str] = []
    problems: list[str] = []
    for folder, agents in libraries.items():
        if different and not holds_behaviors(folder):
            without += agents
            continue
        try:
            there = open_library(folder)
        except LibraryError as error:
            if not different:
                raise
            problems.append(f"{_whose(folder, agents)}: {error.problem.splitlines()[0]}")
            continue
        there.load(strict=False)
        if there.problems:
            names = some(sorted(there.problems))
            problems.append(f"{_whose(folder, agents)}: {names} cannot be used")
        for name in there.names():
            row = _row(name, there.file(name))
            found.setdefault((name, row["checksum"]), row)["agents"] += agents
    data = [found[key] for key in sorted(found)]
    if json != "-":
        console.out().print(_table(data, with_agents=different))
    if without:
        console.note(f"nothing is saved in the libraries of {some(without)}")
    console.write_json(json, data)
    if problems:
        raise LibraryError("\n".join(problems), Do.CHECK_LIBRARY())


def _whose(folder: Path, agents: list[str]) -> str:
    """Return by whose name a library is known: its agents', or its own."""
    from hitab_core import some

    return some(agents) if agents else str(folder)


def _row(name: str, file: Any) -> dict[str, Any]:
    """Return what is listed of a behavior file."""
    automaton = file.automaton
    return {
        "name": name,
        "parameters": list(automaton.parameters),
        "states": list(automaton.labels),
        "features": [str(feature) for feature in automaton.features],
        "examples": len(automaton.examples),
        "default_examples": sum(e.is_default for e in automaton.examples),
        "version": file.provenance.version,
        "created": file.provenance.created,
        "checksum": file.checksum,
        "agents": [],
    }


def _table(data: list[dict[str, Any]], *, with_agents: bool) -> Any:
    from hitab_core import some

    columns = ["behavior", "examples", "states", "features", "version", "created"]
    rows = [
        [
            row["name"],
            str(row["examples"]),
            ", ".join(row["states"]),
            ", ".join(row["features"]),
            str(row["version"]),
            row["created"][:10],
            *([some(row["agents"])] if with_agents else []),
        ]
        for row in data
    ]
    return console.table([*columns, *(["agents"] if with_agents else [])], rows)


@app.command()
def show(
    name: Name,
    library: Library = None,
    agent: Agent = None,
    swarm: SwarmName = None,
    picture: Annotated[
        Path | None, typer.Option("--picture", help="Draw it to a PNG or SVG file instead.")
    ] = None,
    deep: Annotated[
        bool, typer.Option("--deep", help="Also show the automata that it uses.")
    ] = False,
) -> None:
    """Show a behavior: its states, its transitions and its trees.

    Examples:

      hitab library show Keepaway

      hitab library show Keepaway --deep --picture keepaway.svg
    """
    there = opened(library, agent, swarm, "" if deep else name)
    loaded = there.load(strict=False)
    automata = [there.file(_known(name, loaded, there.problems)).automaton]
    if deep:
        from hitab_core import Repertoire

        made_of = Repertoire(there.domain, loaded).needed_by(name)
        automata = [loaded[part] for part in made_of if part in loaded]
    if picture is not None:
        from hitab_core import draw_automata

        console.say(f"drawn to {draw_automata(automata, picture)}")
        return
    from hitab_core import automaton_as_text

    console.say("\n\n".join(automaton_as_text(automaton) for automaton in automata))


def _known(name: str, loaded: Any, problems: Mapping[str, str]) -> str:
    from hitab_core import LibraryError, has

    if name in problems:
        raise LibraryError(problems[name])
    if name not in loaded:
        raise LibraryError(f'no behavior "{name}" {has(loaded, name)}')
    return name


@app.command()
def check(library: Library = None, agent: Agent = None, swarm: SwarmName = None) -> None:
    """Check all files of a library, or of all libraries of the swarm that is up.

    This covers their format, their digests and whether they fit together.

    Example:

      hitab library check -l hitab-demo/library
    """
    from hitab_bringup.opened_library import open_library
    from hitab_core import LibraryError, Remedy

    wrong: list[str] = []
    remedies: list[Remedy] = []
    for folder in chosen_folders(library, agent, swarm):
        there = open_library(folder)
        losses = there.edition(strict=False).losses
        bad, known = len(there.problems), len(there.problems) + len(there.names())
        if bad:
            behaviors = quantity(known, "behavior")
            wrong.append(f"{there.folder}: {bad} of {behaviors} cannot be used")
        wrong += [there.problems[name] for name in sorted(there.problems)]
        remedies += [remedy for ways in losses.remedies.values() for remedy in ways]
        if not losses:
            names = quantity(len(there.names()), "behavior")
            console.say(f"{there.folder}: {names}, nothing is wrong")
    if wrong:
        raise LibraryError("\n".join(wrong), *remedies)


@app.command()
def diff(
    name: Name,
    before: Annotated[
        int | None, typer.Argument(help="A version. Default: the one before.", min=1)
    ] = None,
    after: Annotated[
        int | None, typer.Argument(help="Another. Default: the newest.", min=1)
    ] = None,
    library: Library = None,
    agent: Agent = None,
    swarm: SwarmName = None,
) -> None:
    """Show the differences between two versions of a behavior.

    Examples:

      hitab library diff Keepaway

      hitab library diff Keepaway 1 3
    """
    from hitab_core import LibraryError
    from hitab_core.library import difference

    there = opened(library, agent, swarm, name)
    there.load(strict=False)
    versions = there.versions(name)
    if not versions:
        _known(name, there.names(), {})
    if len(versions) < 2 and before is None:
        raise LibraryError(f'{there.folder}: "{name}" has no earlier version to compare with')
    old = there.version(name, before if before is not None else versions[-2])
    new = there.version(name, after if after is not None else versions[-1])
    console.say(f"{name}: version {old.provenance.version} to {new.provenance.version}")
    console.say(str(difference(old, new)))


library_changes.register(app)
recording.register_in_library(app)
