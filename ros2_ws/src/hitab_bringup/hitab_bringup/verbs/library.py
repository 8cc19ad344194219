"""Verbs for libraries of trained behaviors: list, show, check, diff, restore, accept."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from hitab_client import console
from hitab_client.command_options import JsonPath, SwarmName
from hitab_core import quantity

app = typer.Typer(help="Inspect libraries of trained behaviors.", no_args_is_help=True)

Library = Annotated[
    Path | None,
    typer.Option(
        "--library",
        "-l",
        envvar="HITAB_LIBRARY",
        help="A library folder. Default: that of --agent in the swarm that is up, else the "
        "shipped one.",
        show_default=False,
    ),
]
Agent = Annotated[
    str | None,
    typer.Option("--agent", help="The agent whose library to use; its swarm must be up."),
]
Name = Annotated[str, typer.Argument(help="Name of a behavior.")]


def _open(library: Path | None, agent: str | None, swarm: str | None = None) -> Any:
    from hitab_bringup.opened_library import open_library

    return open_library(_folder(library, agent, swarm))


def _folder(library: Path | None, agent: str | None, swarm: str | None) -> Path:
    from hitab_bringup.shipped import shipped
    from hitab_bringup.swarm_file import read_swarm
    from hitab_bringup.swarm_processes import library_of
    from hitab_client import SwarmError
    from hitab_client.domain_ids import chosen_by_user
    from hitab_client.swarm_choice import find_meant
    from hitab_core import has

    if library is not None:
        return library
    if agent is None:
        return shipped("libraries", "keepaway")
    found = find_meant(swarm, chosen_by_user())
    if found is None:
        raise SwarmError("no swarm is up; name a library folder with --library")
    folder, record = found
    for described in read_swarm(Path(record.description)).members:
        if described.name == agent:
            return library_of(described, folder.path)
    raise SwarmError(f'no agent "{agent}" in swarm {record.swarm} {has(record.agents, agent)}')


@app.command("list")
def list_behaviors(
    library: Library = None, agent: Agent = None, swarm: SwarmName = None, json: JsonPath = None
) -> None:
    """List the behaviors of a library.

    Examples:

      hitab library list -l hitab-demo/library

      hitab library list --agent keeper_1
    """
    opened = _open(library, agent, swarm)
    opened.load(strict=False)
    data = []
    for name in opened.names():
        file = opened.file(name)
        automaton = file.automaton
        data.append(
            {
                "name": name,
                "parameters": list(automaton.parameters),
                "states": list(automaton.labels),
                "features": [str(feature) for feature in automaton.features],
                "examples": len(automaton.examples),
                "default_examples": sum(e.is_default for e in automaton.examples),
                "version": file.provenance.version,
                "created": file.provenance.created,
                "checksum": file.checksum,
            }
        )
    if json != "-":
        from rich.table import Table

        table = Table(box=None, pad_edge=False)
        for column in ("behavior", "examples", "states", "features", "version", "created"):
            table.add_column(column)
        for row in data:
            table.add_row(
                row["name"],
                str(row["examples"]),
                ", ".join(row["states"]),
                ", ".join(row["features"]),
                str(row["version"]),
                row["created"][:10],
            )
        console.out().print(table)
    for problem in opened.problems.values():
        console.error(problem)
    console.write_json(json, data)


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
    opened = _open(library, agent, swarm)
    loaded = opened.load(strict=False)
    automata = [opened.file(_known(name, loaded)).automaton]
    if deep:
        from hitab_core import Repertoire

        made_of = Repertoire(opened.domain, loaded).needed_by(name)
        automata = [loaded[part] for part in made_of if part in loaded]
    if picture is not None:
        from hitab_core import draw_automata

        console.say(f"drawn to {draw_automata(automata, picture)}")
        return
    from hitab_core import automaton_as_text

    console.say("\n\n".join(automaton_as_text(automaton) for automaton in automata))


def _known(name: str, loaded: Any) -> str:
    from hitab_core import LibraryError, has

    if name not in loaded:
        raise LibraryError(f'no behavior "{name}" {has(loaded, name)}')
    return name


@app.command()
def check(library: Library = None, agent: Agent = None, swarm: SwarmName = None) -> None:
    """Check all files of a library: format, digests and whether they fit together.

    Example:

      hitab library check -l hitab-demo/library
    """
    opened = _open(library, agent, swarm)
    loaded = opened.load()
    console.say(f"{opened.folder}: {quantity(len(loaded), 'behavior')}, nothing is wrong")


@app.command()
def diff(
    name: Name,
    before: Annotated[
        int | None, typer.Argument(help="A version; default: the one before.")
    ] = None,
    after: Annotated[int | None, typer.Argument(help="Another; default: the newest.")] = None,
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

    opened = _open(library, agent, swarm)
    opened.load(strict=False)
    versions = opened.versions(name)
    if not versions:
        _known(name, opened.names())
    if len(versions) < 2 and before is None:
        raise LibraryError(f'{opened.folder}: "{name}" has no earlier version to compare with')
    old = opened.version(name, before if before is not None else versions[-2])
    new = opened.version(name, after if after is not None else versions[-1])
    console.say(f"{name}: version {old.provenance.version} to {new.provenance.version}")
    console.say(str(difference(old, new)))


@app.command()
def restore(
    name: Name,
    version: Annotated[int, typer.Argument(help="Number of the version; see the list.")],
    library: Library = None,
    agent: Agent = None,
    swarm: SwarmName = None,
) -> None:
    """Make an earlier version of a behavior the newest one.

    A running agent uses it after it reloads its library.

    Example:

      hitab library restore Keepaway 2
    """
    opened = _open(library, agent, swarm)
    path = opened.restore(name, version)
    console.say(f"restored version {version} of {name} to {path}")


@app.command()
def accept(path: Annotated[Path, typer.Argument(help="A behavior file.")]) -> None:
    """Accept a behavior file that was edited by hand: check it and update its digests.

    Example:

      hitab library accept my_library/ApproachBall.hfa.yaml
    """
    from hitab_bringup.opened_library import open_library
    from hitab_core.library import accept_edit

    console.say(f"accepted {accept_edit(path, open_library(path.parent).domain)}")
