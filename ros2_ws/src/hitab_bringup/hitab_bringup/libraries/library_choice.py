"""Choice of a library: a folder, a library of a swarm that was up, or a shipped one."""

from __future__ import annotations

import json
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from hitab_bringup.libraries.opened_library import domain_in
from hitab_bringup.swarm_files.swarm_description import SwarmDescription
from hitab_client import DescriptionError, SwarmError, console
from hitab_client.connecting.domain_ids import chosen_by_user
from hitab_client.runs.run_folder import WORLD_FILES, libraries_of, running_swarms, state_home
from hitab_client.runs.shipped import shipped_folders
from hitab_client.runs.swarm_choice import find_meant, name_to_choose
from hitab_core import HitabError, LibraryError, has, load_domain
from hitab_core.library import BEHAVIOR_SUFFIX


def known_libraries() -> dict[str, Path]:
    """Return the libraries with names: those of swarms, kept between runs, and shipped ones."""
    kept = {
        f"{path.parent.parent.name}/{path.name}": path
        for path in sorted(state_home().glob("*/libraries/*"))
        if path.is_dir() and holds_behaviors(path)
    }
    return kept | shipped_libraries()


def holds_behaviors(folder: Path) -> bool:
    """Return whether a folder has any behavior files."""
    return any(folder.glob(f"*{BEHAVIOR_SUFFIX}"))


def shipped_libraries() -> dict[str, Path]:
    """Return the libraries that come with HiTAB, by name."""
    folders = shipped_folders("libraries")
    return {path.name: path for folder in folders for path in sorted(folder.iterdir())}


def libraries_meant(
    library: str | None, agent: str | None, swarm: str | None
) -> dict[Path, list[str]]:
    """Return the folders that a verb's options choose, each with the agents that use it.

    Args:
        library: a folder; ``SWARM/LIBRARY``, kept for a swarm between its runs; or the name of a
            shipped library. A library given like this has no agents here.
        agent: an agent of the swarm that is up. Without library and agent, all libraries of the
            swarm are chosen.
        swarm: the swarm, if several are up.

    Raises:
        LibraryError, SwarmError: if there is no such library; names the existing ones.
    """
    if library is not None:
        return {named_library(library): []}
    found = find_meant(swarm, chosen_by_user())
    if found is None:
        known = known_libraries()
        ending = f"/{agent}" if agent else ""
        example = next((name for name in known if name.endswith(ending)), next(iter(known)))
        raise LibraryError(
            f"no swarm is up; choose a library, for example with -l {example} {has(known)}"
        )
    folder, record = found
    _load_worlds(folder.path)
    used = libraries_of(folder.path)
    if agent is not None and agent not in used and agent in record.agents:
        process = next(name for name, inside in record.processes.items() if agent in inside)
        moved = f"{record.swarm}/{process}"
        here = (
            f", or choose its library here with -l {moved}" if moved in known_libraries() else ""
        )
        raise SwarmError(
            f"{agent} is of another machine than {record.machine}, which keeps its library; ask "
            f"there{here}"
        )
    if agent is not None and agent not in used:
        raise SwarmError(f'no agent "{agent}" in swarm {record.swarm} {has(used, agent)}')
    libraries: dict[Path, list[str]] = {}
    for name in used if agent is None else (agent,):
        libraries.setdefault(used[name], []).append(name)
    return libraries


def named_library(text: str) -> Path:
    """Return the folder of a library: a path, ``SWARM/LIBRARY``, or the name of a shipped one.

    Raises:
        LibraryError: if there is no such library; names the existing ones.
    """
    path = Path(text).expanduser()
    known = known_libraries()
    if not path.is_dir() and text not in known:
        raise LibraryError(f'"{text}" is neither a folder nor a library {has(known, text)}')
    if path.is_dir():
        return path
    if known[text].is_relative_to(state_home()):
        _load_worlds(known[text].parents[1])
    return known[text]


def _load_worlds(folder: Path) -> None:
    """Load the worlds in one file of a swarm's run folder, which libraries find by name."""
    with suppress(OSError, ValueError, HitabError):  # opening the library reports missing worlds
        for file in json.loads((folder / WORLD_FILES).read_text(encoding="utf-8")):
            load_domain(file)


def library_meant(
    library: str | None, agent: str | None, swarm: str | None, name: str = ""
) -> Path:
    """Return the folder that a verb's options choose; several folders must be equal.

    Args:
        library, agent, swarm: see `libraries_meant`.
        name: name of a behavior to compare alone, in the libraries that have it; empty to
            compare whole libraries.

    Raises:
        LibraryError: if the libraries differ (names an agent of each), or none has the behavior.
        SwarmError: if there is no such agent or swarm.
    """
    libraries = libraries_meant(library, agent, swarm)
    having = {
        f: a for f, a in libraries.items() if not name or (f / f"{name}{BEHAVIOR_SUFFIX}").exists()
    }
    if len(libraries) == 1:
        return next(iter(libraries))
    if not having:
        saved = {file.removesuffix(BEHAVIOR_SUFFIX) for f in libraries for file, _ in _files(f)}
        raise LibraryError(f'no library of the swarm has "{name}" {has(saved, name)}')
    owners = [agents[0] for agents in having.values()]
    if not _are_equal(having, name):
        what = f'"{name}" differs in' if name else "there are differences between"
        raise LibraryError(
            f"{what} the libraries of the swarm; name the agent whose library you mean with "
            f"--agent {has(owners)}"
        )
    others = ", which the others of the swarm equal" if _are_equal(libraries) else ""
    console.note(f"the library of {owners[0]}{others}")
    return next(iter(having))


def _are_equal(libraries: Iterable[Path], name: str = "") -> bool:
    """Whether libraries have the same files, or the same file of a behavior."""
    return len({_files(folder, name) for folder in libraries}) == 1


def _files(folder: Path, name: str = "") -> frozenset[tuple[str, bytes]]:
    pattern = f"{name or '*'}{BEHAVIOR_SUFFIX}"
    return frozenset((path.name, path.read_bytes()) for path in folder.glob(pattern))


def users_of(library: Path) -> list[tuple[str, list[str]]]:
    """Return the running swarms that use a library, each with the agents concerned."""
    found = [
        (
            name_to_choose(record),
            [a for a, used in libraries_of(folder.path).items() if used == library.resolve()],
        )
        for folder, record in running_swarms()
    ]
    return [(swarm, agents) for swarm, agents in found if agents]


def with_library(swarm: SwarmDescription, text: str) -> SwarmDescription:
    """Return a swarm whose agents use a library, reading and saving there.

    Commanders do not use the library, unless it is a library of commanders: then the commanders of
    that kind use it. A folder that does not exist is a new library.

    Args:
        swarm: the swarm.
        text: the library, see `libraries_meant`.

    Raises:
        DescriptionError: if the library fits no member of the swarm.
        LibraryError: if the library is a shipped one, which is read-only.
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
    domains = sorted({_named(agent.domain) for agent in swarm.agents})
    if domain is None and len(domains) > 1:
        raise DescriptionError(
            f'the agents of swarm "{swarm.name}" are of several domains {has(domains)} and cannot '
            "share a new library; write `library:` for each of them in its description"
        )
    theirs = {_named(member.domain) for member in swarm.members}
    if domain not in {None, *theirs}:
        raise DescriptionError(
            f'{folder}: its behaviors are of domain "{domain}", and no agent of swarm '
            f'"{swarm.name}" is {has(theirs)}'
        )
    trained_in = domain or domains[0]
    return replace(
        swarm,
        agents=tuple(
            replace(a, library=folder) if _named(a.domain) == trained_in else a
            for a in swarm.agents
        ),
        commanders=tuple(
            replace(c, library=folder) if c.domain == trained_in else c for c in swarm.commanders
        ),
    )


def _named(domain: str) -> str:
    """Return a domain's name in libraries; for a domain in a file, the name of the file."""
    return Path(domain).stem if domain.endswith(".py") else domain
