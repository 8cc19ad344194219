"""Options and arguments of the verbs for libraries, and the library that they mean."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

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
    """Return the library that the options mean; see `hitab_bringup.library_choice`."""
    from hitab_bringup.library_choice import library_meant
    from hitab_bringup.opened_library import open_library

    return open_library(library_meant(library, agent, swarm, name))
