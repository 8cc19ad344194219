"""The verb `hitab export`, which writes a learned behavior as a program."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hitab_cli import Library, opened, write_new
from hitab_client import console
from hitab_client.terminal.cli_options import SwarmName
from hitab_core import LibraryError, Term


def register(app: typer.Typer) -> None:
    """Add `hitab export`."""
    app.command(rich_help_panel="Perform")(export)


def export(
    behavior: Annotated[list[str], typer.Argument(metavar="[AGENT] BEHAVIOR")],
    to: Annotated[str, typer.Option("--to", metavar="LANGUAGE")],
    output: Annotated[Path | None, typer.Option("--output", "-o")] = None,
    force: Annotated[bool, typer.Option("--force")] = False,
    library: Library = None,
    swarm: SwarmName = None,
) -> None:
    """Write a learned behavior, and all its parts, as a program that needs no HiTAB.

    Args:
        behavior: Whose behavior, and its name, with a target for each parameter. With --library,
            the name alone.
        to: python, cpp or bt.xml (BehaviorTree.CPP).
        output: The file to write. Default: the behavior's name, in this folder.
        force: Replace the file if it exists.

    Examples:
      hitab export keeper_1 Keepaway --to python
      hitab export "Carry(squad_box)" --library foraging --to cpp -o carry.hpp
    """
    from hitab_export import LANGUAGES, exported

    if len(behavior) > 2 or (library is not None and len(behavior) > 1):
        raise LibraryError(
            "name an agent and one behavior, or only the behavior of a --library; a behavior with "
            'targets is one argument, such as "Carry(squad_box)"'
        )
    *agent, name = behavior
    there = opened(library, agent[0] if agent else None, swarm, Term.parse(name).name)
    text = exported(there, name, to)
    path = output or Path(name.split("(")[0] + LANGUAGES[to].suffix)
    if path.is_dir():
        raise LibraryError(f"{path} is a folder; choose a file with -o FILE")
    write_new(path, text, "" if force else "--force")
    console.say(f"wrote {name} to {path}")
