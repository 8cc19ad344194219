"""Verbs for libraries of trained behaviors: list, show, check, diff, and the changing verbs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from hitab_cli.verbs.libraries import labeling_verbs as labeling
from hitab_cli.verbs.libraries import library_change_verbs as library_changes
from hitab_cli.verbs.libraries.library_options import Agent, Library, Name, opened
from hitab_client import console
from hitab_client.terminal.cli_options import JsonPath, SwarmName
from hitab_core import Fix, LibraryError, Remedy, has, load_domain, quantity, some

app = typer.Typer(help="Inspect and change libraries of trained behaviors.")


@app.callback()
def read_file(
    file: Annotated[
        Path | None,
        typer.Option(
            "--file",
            metavar="FILE",
            help="The Python file of the agents' world, if they are of a world in one file.",
        ),
    ] = None,
) -> None:
    """Inspect and change libraries of trained behaviors."""
    if file is not None:
        load_domain(str(file))  # libraries find the domain by its name


@app.command("list")
def list_behaviors(
    library: Library = None, agent: Agent = None, swarm: SwarmName = None, json: JsonPath = None
) -> None:
    """List the behaviors of a library, or of all libraries of the swarm that is up.

    Examples:
      hitab library list -l hitab-demo/library
      hitab library list --agent keeper_1
    """
    from hitab_bringup import holds_behaviors, libraries_meant, open_library

    libraries = libraries_meant(library, agent, swarm)
    several = len(libraries) > 1
    found: dict[tuple[str, str], dict[str, Any]] = {}
    problems: list[str] = []
    for folder, agents in libraries.items():
        if several and not holds_behaviors(folder):
            console.note(f"nothing is saved in the library of {some(agents)}")
            continue
        try:
            chosen = open_library(folder)
        except LibraryError as error:
            problems.append(f"{some(agents)}: {error.problem}" if several else error.problem)
            continue
        chosen.load(strict=False)
        if chosen.problems:
            names = some(sorted(chosen.problems))
            whose = some(agents) or str(folder)
            problems.append(f"{whose}: {names} cannot be used")
        for name in sorted(chosen.files):
            row = _row(name, chosen.file(name))
            found.setdefault((name, row["checksum"]), row)["agents"] += agents
    data = [found[key] for key in sorted(found)]
    rows = [
        [
            row["name"],
            str(row["examples"]),
            ", ".join(row["states"]),
            ", ".join(row["features"]),
            str(row["version"]),
            row["created"][:10],
            *[some(row["agents"])] * several,
        ]
        for row in data
    ]
    columns = ["behavior", "examples", "states", "features", "version", "created"]
    console.show(json, data, console.table([*columns, *["agents"] * several], rows))
    if problems:
        raise LibraryError("\n".join(problems), Fix.CHECK_LIBRARY())


def _row(name: str, file: Any) -> dict[str, Any]:
    """Return the row of a behavior file in the list."""
    automaton = file.automaton
    return {
        "name": name,
        "parameters": list(automaton.parameters),
        "states": list(automaton.labels),
        "features": list(automaton.feature_labels),
        "examples": len(automaton.examples),
        "default_examples": sum(e.is_default for e in automaton.examples),
        "version": file.provenance.version,
        "created": file.provenance.created,
        "checksum": file.checksum,
        "agents": [],
    }


@app.command()
def show(
    name: Name,
    library: Library = None,
    agent: Agent = None,
    swarm: SwarmName = None,
    picture: Annotated[Path | None, typer.Option("--picture")] = None,
    deep: Annotated[bool, typer.Option("--deep")] = False,
) -> None:
    """Show a behavior: its states, its transitions and its trees.

    Args:
        picture: Draw it to a PNG or SVG file instead.
        deep: Also show the automata used by the behavior.

    Examples:
      hitab library show Keepaway
      hitab library show Keepaway --deep --picture keepaway.svg
    """
    chosen = opened(library, agent, swarm, "" if deep else name)
    loaded = chosen.load(strict=False)
    automata = [chosen.file(_known(name, loaded, chosen.problems)).automaton]
    if deep:
        from hitab_core import Repertoire

        made_of = Repertoire(chosen.domain, loaded).needed_by(name)
        automata = [loaded[part] for part in made_of if part in loaded]
    if picture is not None:
        from hitab_core import draw_automata

        console.say(f"drawn to {draw_automata(automata, picture)}")
        return
    from hitab_bringup import in_words
    from hitab_core import automaton_as_text

    console.say("\n\n".join(automaton_as_text(automaton) for automaton in automata))
    for shown in automata:
        file = chosen.files.get(shown.name)
        for one in file.expectations if file is not None else ():
            console.say("\n" + in_words(one, chosen.domain))
        library_changes.tell_broken(chosen, *[shown.name] * (file is not None))


def _known(name: str, loaded: Any, problems: Mapping[str, str]) -> str:

    if name in problems:
        raise LibraryError(problems[name])
    if name not in loaded:
        raise LibraryError(f'no behavior "{name}" {has(loaded, name)}')
    return name


@app.command()
def check(library: Library = None, agent: Agent = None, swarm: SwarmName = None) -> None:
    """Check all files of a library, or of all libraries of the swarm that is up.

    This covers the format of the files and whether they fit together, and lists files that were
    edited by hand.

    Example:
      hitab library check -l hitab-demo/library
    """
    from hitab_bringup import holds_behaviors, libraries_meant, open_library

    folders = [*libraries_meant(library, agent, swarm)]
    if len(folders) > 1 and not any(map(holds_behaviors, folders)):
        raise LibraryError("nothing is saved in the libraries of the swarm yet")
    wrong: list[str] = []
    remedies: list[Remedy] = []
    for folder in folders:
        if len(folders) > 1 and not holds_behaviors(folder):
            continue
        chosen = open_library(folder)
        losses = chosen.loaded(strict=False).losses
        bad, known = len(chosen.problems), len(chosen.problems) + len(sorted(chosen.files))
        if bad:
            behaviors = quantity(known, "behavior")
            wrong.append(f"{chosen.folder}: {bad} of {behaviors} cannot be used")
        wrong += [chosen.problems[name] for name in sorted(chosen.problems)]
        remedies += [remedy for ways in losses.remedies.values() for remedy in ways]
        library_changes.tell_broken(chosen, *sorted(chosen.files))
        if not losses:
            names = quantity(len(sorted(chosen.files)), "behavior")
            console.say(f"{chosen.folder}: {names}, nothing is wrong")
        for name in sorted(chosen.files):
            for text in chosen.file(name).edits:
                console.say(text)
    if wrong:
        raise LibraryError("\n".join(wrong), *remedies)


@app.command()
def diff(
    name: Name,
    before: Annotated[int | None, typer.Argument(min=1)] = None,
    after: Annotated[int | None, typer.Argument(min=1)] = None,
    library: Library = None,
    agent: Agent = None,
    swarm: SwarmName = None,
) -> None:
    """Show the differences between two versions of a behavior.

    Args:
        before: A version. Default: the one before.
        after: Another. Default: the newest, or the file if it was edited since.

    Examples:
      hitab library diff Keepaway
      hitab library diff Keepaway 1 3
    """
    from hitab_core.library import difference

    chosen = opened(library, agent, swarm, name)
    chosen.load(strict=False)
    versions = chosen.on_disk.versions(name)
    if not versions:
        _known(name, sorted(chosen.files), {})
    now = chosen.files.get(name)
    if versions and not before and now and now != chosen.on_disk.version(name, versions[-1]):
        old, new = chosen.on_disk.version(name, versions[-1]), now
        console.say(f"{name}: version {versions[-1]} to the edited file")
    elif len(versions) < 2 and before is None:
        raise LibraryError(f'{chosen.folder}: "{name}" has no earlier version to compare with')
    else:
        first, last = before or versions[-2], after or versions[-1]
        old, new = (chosen.on_disk.version(name, number) for number in (first, last))
        console.say(f"{name}: version {first} to {last}")
    console.say(difference(old, new, chosen.domain))


for changes in (
    library_changes.restore,
    library_changes.expect,
    library_changes.delete,
    library_changes.rename,
    library_changes.export,
):
    app.command()(changes)
app.command("import")(library_changes.import_)
app.command()(library_changes.reload)
app.command()(labeling.label)
