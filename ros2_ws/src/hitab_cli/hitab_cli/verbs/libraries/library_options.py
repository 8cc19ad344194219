"""Options and arguments of the verbs for libraries, and the library that they choose."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hitab_core import LibraryError

if TYPE_CHECKING:
    from hitab_core import BehaviorLibrary

Library = Annotated[
    str | None,
    typer.Option(
        "--library",
        "-l",
        metavar="LIBRARY",
        envvar="HITAB_LIBRARY",
        help="A folder, SWARM/LIBRARY of a swarm that was up, or a shipped library. Default: that "
        "of the swarm that is up.",
        show_default=False,
    ),
]
Agent = Annotated[
    str | None,
    typer.Option("--agent", "-a", help="The agent whose library to use; its swarm must be up."),
]
Name = Annotated[str, typer.Argument(help="Name of a behavior.")]


def opened(
    library: str | None, agent: str | None, swarm: str | None = None, name: str = ""
) -> BehaviorLibrary:
    """Return the library that the options choose; see `hitab_bringup.libraries.library_choice`."""
    from hitab_bringup import library_meant, open_library

    return open_library(library_meant(library, agent, swarm, name))


def write_new(path: Path, text: str, option: str) -> None:
    """Write a file; refuse to replace another text and name the option, unless that is ""."""
    from hitab_core.library.durable_files import file_errors, write_durably

    with file_errors(path, "write"):
        if option and path.exists() and path.read_bytes() != text.encode():
            raise LibraryError(
                f"{path} exists already; choose another with -o FILE, or give {option}"
            )
        write_durably(path, text.encode())
