"""Which library a person means: a folder, one of a swarm that was up, or a shipped one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from hitab_bringup.libraries import libraries_of
from hitab_bringup.opened_library import domain_in
from hitab_bringup.swarm_description import AgentDescription, SwarmDescription
from hitab_client import DescriptionError, RunFolder, SwarmError
from hitab_client.run_folder import running_swarms, state_home
from hitab_client.shipped import shipped_folders
from hitab_client.swarm_choice import name_to_choose
from hitab_core import LibraryError, has
from hitab_core.library import SUFFIX


def named_library(text: str) -> Path:
    """Return the library that a text names.

    Args:
        text: a folder; ``SWARM/LIBRARY``, kept for a swarm between its runs; or the name of a
            shipped library.

    Raises:
        LibraryError: naming the libraries that there are.
    """
    path = Path(text).expanduser()
    if path.is_dir():
        return path
    known = known_libraries()
    if text in known:
        return known[text]
    raise LibraryError(f'"{text}" is neither a folder nor a library {has(known, text)}')


def known_libraries() -> dict[str, Path]:
    """Return the libraries that have a name: those of swarms, kept between runs, and shipped."""
    return _of_swarms() | shipped_libraries()


def _of_swarms() -> dict[str, Path]:
    home = state_home()
    return {
        f"{path.parent.parent.name}/{path.name}": path
        for path in sorted(home.glob("*/libraries/*"))
        if path.is_dir() and holds_behaviors(path)
    }


def holds_behaviors(folder: Path) -> bool:
    """Return whether a folder has any behavior files."""
    return any(folder.glob(f"*{SUFFIX}"))


def shipped_libraries() -> dict[str, Path]:
    """Return the libraries that come with HiTAB, by name."""
    folders = shipped_folders("libraries")
    return {path.name: path for folder in folders for path in sorted(folder.iterdir())}


def library_of_agent(agent: str, folder: RunFolder, swarm: str) -> Path:
    """Return the library of an agent of a swarm that is up.

    Raises:
        SwarmError: if the swarm has no such agent.
    """
    libraries = libraries_of(folder.path)
    if agent not in libraries:
        raise SwarmError(f'no agent "{agent}" in swarm {swarm} {has(libraries, agent)}')
    return libraries[agent]


def libraries_in_use(folder: RunFolder) -> dict[Path, list[str]]:
    """Return the libraries of a swarm that is up, each with the agents that use it."""
    found: dict[Path, list[str]] = {}
    for agent, library in libraries_of(folder.path).items():
        found.setdefault(library, []).append(agent)
    return found


def the_only_one(libraries: Mapping[Path, list[str]], swarm: str, name: str = "") -> Path:
    """Return the only library of a swarm, or one that all the others equal.

    Args:
        libraries: of the swarm, each with the agents that use it.
        swarm: its name.
        name: of a behavior, if only that matters: libraries without it do not count.

    Raises:
        LibraryError: if they differ, naming an agent of each; if none has the behavior.
    """
    if name:
        having = {f: agents for f, agents in libraries.items() if (f / f"{name}{SUFFIX}").exists()}
        if not having:
            saved = {file.removesuffix(SUFFIX) for f in libraries for file, _ in _files(f)}
            raise LibraryError(f'no library of swarm {swarm} has "{name}" {has(saved, name)}')
        libraries = having
    if are_equal(libraries, name):
        return next(iter(libraries))
    owners = [agents[0] for agents in libraries.values()]
    what = f'"{name}" in the' if name else "the"
    raise LibraryError(
        f"{what} libraries of swarm {swarm} differ{'s' if name else ''}; name the agent whose "
        f"library you mean with --agent {has(owners)}"
    )


def are_equal(libraries: Iterable[Path], name: str = "") -> bool:
    """Whether libraries have the same files, or the same file of a behavior."""
    return len({_files(folder, name) for folder in libraries}) == 1


def none_chosen(agent: str | None = None) -> LibraryError:
    """Return an error for when no library is named and no swarm is up.

    Args:
        agent: whose library was meant.
    """
    known = known_libraries()
    ending = f"/{agent}" if agent else ""
    example = next((name for name in known if name.endswith(ending)), next(iter(known)))
    return LibraryError(
        f"no swarm is up; choose a library, for example with -l {example} {has(known)}"
    )


def _files(folder: Path, name: str = "") -> frozenset[tuple[str, bytes]]:
    pattern = f"{name or '*'}{SUFFIX}"
    return frozenset((path.name, path.read_bytes()) for path in folder.glob(pattern))


def users_of(library: Path) -> list[tuple[str, list[str]]]:
    """Return what chooses each swarm that is up and uses a library, and its agents that do."""
    library = library.resolve()
    found = []
    for folder, record in running_swarms():
        agents = [a for a, used in libraries_of(folder.path).items() if used == library]
        if agents:
            found.append((name_to_choose(record), agents))
    return found


def with_library(swarm: SwarmDescription, text: str) -> SwarmDescription:
    """Return a swarm whose agents use a library, reading and saving there.

    Commanders are left out, unless it is a library of commanders: then the commanders of that kind
    use it. A folder that does not exist is a new library.

    Args:
        swarm: the swarm.
        text: the library, see `named_library`.

    Raises:
        DescriptionError: if it belongs to no member of the swarm.
        LibraryError: if it is a shipped one, into which nothing is saved.
    """
    folder = Path(text).expanduser()
    if not folder.is_dir():
        folder = known_libraries().get(text, folder)
    folder = folder.resolve()
    if folder in {path.resolve() for path in shipped_libraries().values()}:
        raise LibraryError(
            f"{folder} is shipped with HiTAB, and the agents would save into it; copy it, and "
            "give the copy to --library"
        )
    domain = domain_in(folder) if folder.is_dir() else None
    members = _members_of(swarm, domain)
    if not members:
        theirs = sorted({member.domain for member in swarm.members})
        raise DescriptionError(
            f'{folder}: its behaviors are of domain "{domain}", and no agent of swarm '
            f'"{swarm.name}" is {has(theirs)}'
        )

    def given(member: AgentDescription) -> bool:
        return member.name in members

    return replace(
        swarm,
        agents=tuple(replace(a, library=folder) if given(a) else a for a in swarm.agents),
        commanders=tuple(replace(c, library=folder) if given(c) else c for c in swarm.commanders),
    )


def _members_of(swarm: SwarmDescription, domain: str | None) -> set[str]:
    """Return the names of those that a library is for; without a domain: of all agents.

    Raises:
        DescriptionError: if a new library would be for agents of several domains.
    """
    if domain is not None:
        return {member.name for member in swarm.members if member.domain == domain}
    domains = sorted({agent.domain for agent in swarm.agents})
    if len(domains) > 1:
        raise DescriptionError(
            f'the agents of swarm "{swarm.name}" are of several domains {has(domains)} and cannot '
            "share a new library; write `library:` for each of them in its description"
        )
    return {agent.name for agent in swarm.agents}
