"""Options and arguments of the verbs for libraries, and the library that they mean."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from hitab_client import console

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
) -> Any:
    """Return the library that the options mean; see `chosen_folder`."""
    from hitab_bringup.opened_library import open_library

    return open_library(chosen_folder(library, agent, swarm, name=name))


def chosen_libraries(
    library: str | None, agent: str | None, swarm: str | None
) -> dict[Path, list[str]]:
    """Return the folders that the options mean, each with its agents.

    Without any option, these are all of the swarm that is up if they differ. If they are equal, it
    is one of them, without agents.

    Raises:
        LibraryError, SwarmError: as `chosen_folder`.
    """
    from hitab_bringup import library_choice as choice
    from hitab_client.domain_ids import chosen_by_user
    from hitab_client.swarm_choice import find_meant

    found = None if library or agent else find_meant(swarm, chosen_by_user())
    used = choice.libraries_in_use(found[0]) if found is not None else {}
    if not used or choice.are_equal(used):
        return {chosen_folder(library, agent, swarm): []}
    return used


def chosen_folders(library: str | None, agent: str | None, swarm: str | None) -> list[Path]:
    """Return the folders that the options mean: without any, all of the swarm that is up.

    Raises:
        LibraryError, SwarmError: as `chosen_folder`; also if there is nothing in any of them.
    """
    from hitab_bringup import library_choice as choice
    from hitab_client.domain_ids import chosen_by_user
    from hitab_client.swarm_choice import find_meant
    from hitab_core import LibraryError

    found = None if library or agent else find_meant(swarm, chosen_by_user())
    if found is None:
        return [chosen_folder(library, agent, swarm)]
    folder, record = found
    holding = [f for f in choice.libraries_in_use(folder) if choice.holds_behaviors(f)]
    if not holding:
        raise LibraryError(f"nothing is saved in the libraries of swarm {record.swarm} yet")
    return holding


def chosen_folder(
    library: str | None,
    agent: str | None,
    swarm: str | None,
    *,
    new: bool = False,
    name: str = "",
) -> Path:
    """Return the folder of the library that the options mean.

    Args:
        library: a folder or a name, see `hitab_bringup.library_choice.named_library`.
        agent: of the swarm that is up.
        swarm: the swarm, if several are up.
        new: whether a folder that does not exist may be meant.
        name: of the behavior, if only that matters.

    Raises:
        LibraryError, SwarmError: if there is none, or several; naming those that there are.
    """
    from hitab_bringup import library_choice as choice
    from hitab_client.domain_ids import chosen_by_user
    from hitab_client.swarm_choice import find_meant

    if library is not None:
        if new and library not in choice.known_libraries():
            return Path(library).expanduser()
        return choice.named_library(library)
    found = find_meant(swarm, chosen_by_user())
    if found is None:
        raise choice.none_chosen(agent)
    folder, record = found
    if agent is not None:
        return choice.library_of_agent(agent, folder, record.swarm)
    libraries = choice.libraries_in_use(folder)
    chosen = choice.the_only_one(libraries, record.swarm, name)
    if len(libraries) > 1:
        equal = choice.are_equal(libraries)
        others = ", which the others of the swarm equal" if equal else ""
        console.note(f"the library of {libraries[chosen][0]}{others}")
    return chosen
