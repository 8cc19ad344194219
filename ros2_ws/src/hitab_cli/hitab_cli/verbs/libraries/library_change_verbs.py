"""Verbs that change libraries: restore, expect, delete, rename, export, import, reload."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hitab_cli.verbs.libraries.library_options import Agent, Library, Name, opened, write_new
from hitab_cli.verbs.verb_connection import connection
from hitab_client import SwarmError, console
from hitab_client.terminal.cli_options import SwarmName
from hitab_client.terminal.cli_remedies import as_command, called
from hitab_core import Fix, LibraryError, each_once, has, named_domain, quantity

if TYPE_CHECKING:
    from hitab_core import BehaviorLibrary


def restore(
    name: Name,
    version: Annotated[int | None, typer.Argument(min=1)] = None,
    library: Library = None,
    agent: Agent = None,
    swarm: SwarmName = None,
) -> None:
    """Make an earlier version of a behavior the newest one, even if it was deleted or damaged.

    Args:
        version: Number of the version. Default: the only one; several are listed.

    Example:
      hitab library restore Keepaway 2 --agent keeper_1
    """
    chosen = opened(library, agent, swarm)
    if version is None:
        chosen.load(strict=False)
        versions = chosen.on_disk.versions(name)
        if not versions:
            kept = sorted(path.name for path in (chosen.folder / ".versions").glob("*"))
            raise LibraryError(f'{chosen.folder}: no version of "{name}" was kept {has(kept)}')
        if len(versions) > 1:
            raise LibraryError(f'say which version of "{name}" to restore {has(versions)}')
        (version,) = versions
    path = chosen.restore(name, version)
    console.say(f"restored version {version} of {name} to {path}")
    _tell_of_change(chosen, name)


def delete(
    name: Name,
    anyway: Annotated[bool, typer.Option("--anyway")] = False,
    library: Library = None,
    agent: Agent = None,
    swarm: SwarmName = None,
) -> None:
    """Delete a behavior. Its versions are kept and can be restored.

    Args:
        anyway: Delete it even if other behaviors become unusable.

    Example:
      hitab library delete Chase --agent keeper_1
    """
    chosen = opened(library, agent, swarm)
    users = chosen.remove(name, anyway=anyway)
    console.say(f"deleted {name} from {chosen.folder}")
    if users:
        console.say(f"{', '.join(users)} cannot be used until there is a {name} again")
    number = chosen.on_disk.sound_version(name)
    if number is not None:
        console.say(as_command(Fix.RESTORE(behavior=name, version=number, folder=chosen.folder)))
    else:
        console.say(f"kept the damaged file in {chosen.folder / '.versions' / name}")
    _tell_of_change(chosen)


def rename(
    name: Name,
    new: str,
    with_users: Annotated[bool, typer.Option("--with-users")] = False,
    library: Library = None,
    agent: Agent = None,
    swarm: SwarmName = None,
) -> None:
    """Rename a behavior and, on request, its uses in other behaviors: all or nothing.

    Swarm descriptions, lessons and kinds of commanders that name the behavior do not change.

    Args:
        new: Its new name.
        with_users: Also rename it in the behaviors that use it.

    Example:
      hitab library rename Chase ChaseBall --with-users --agent keeper_1
    """
    chosen = opened(library, agent, swarm)
    users, otherwise = chosen.rename(name, new, with_users=with_users)
    console.say(f"renamed {name} to {new} in {chosen.folder}")
    if users:
        console.say(f"changed what uses it: {', '.join(users)}")
    for user in otherwise:
        console.note(
            f"{user} decides differently now, where its examples contradict each other; see "
            f"`{called()} library diff {user} -l {shlex.quote(str(chosen.folder))}`"
        )
    _tell_of_change(chosen)


def export(
    names: Annotated[list[str] | None, typer.Argument()] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="FILE")] = None,
    replace: Annotated[bool, typer.Option("--replace")] = False,
    library: Library = None,
    agent: Agent = None,
    swarm: SwarmName = None,
) -> None:
    """Write behaviors, with everything that they use, to one file.

    Args:
        names: The behaviors; those that they use are included. Default: all.
        output: The file to write. Default: NAME.bundle.yaml here.
        replace: Replace the file if it exists.

    Examples:
      hitab library export Keepaway --agent keeper_1
      hitab library export -l my_library -o trained.bundle.yaml
    """
    from hitab_core.library import bundle_file_text, texts_with_parts

    chosen = opened(library, agent, swarm)
    chosen.load()
    texts = texts_with_parts(chosen.files, names or chosen.files)
    text = bundle_file_text(texts, chosen.domain.name)
    path = output or Path(f"{names[0] if names else chosen.folder.resolve().name}.bundle.yaml")
    write_new(path, text, "" if replace else "--replace")
    console.say(f"wrote {', '.join(texts)} to {path}")


def import_(
    file: Path,
    dry_run: Annotated[bool, typer.Option("--dry-run")] = False,
    library: Library = None,
    agent: Agent = None,
    swarm: SwarmName = None,
) -> None:
    """Read behaviors from a file into a library: all or none. Replaced files are kept.

    A folder that does not exist is a new library.

    Args:
        file: A file that `hitab library export` wrote.
        dry_run: Only list the behaviors that would be replaced.

    Examples:
      hitab library import Keepaway.bundle.yaml -l my_library --dry-run
      hitab library import Keepaway.bundle.yaml --agent keeper_1
    """
    from hitab_bringup import domain_in, known_libraries, library_meant, open_library
    from hitab_core import BehaviorLibrary
    from hitab_core.library import read_bundle_file

    bundle = read_bundle_file(file)
    is_new = library is not None and library not in known_libraries()
    folder = Path(library or "").expanduser() if is_new else library_meant(library, agent, swarm)
    chosen = (
        BehaviorLibrary(folder, named_domain(bundle.domain))
        if not folder.is_dir() or domain_in(folder) is None
        else open_library(folder)
    )
    chosen.reader.read_all(bundle.texts)
    with chosen.change() as change:
        changed = change.install(bundle.texts)
        replaced = {name: change.before_it(name) for name in changed}
        numbers = dict(change.numbers)
        if not dry_run:
            change.commit()
    if dry_run:
        console.note("nothing is changed; without --dry-run:")
    for name in bundle.texts:
        what = replaced.get(name)
        change_text = f"version {numbers[name]}, replaces {what}" if what else "new"
        console.say(f"{name}: {change_text if name in changed else 'the same is there already'}")
    if changed and not dry_run:
        console.say(f"imported {quantity(len(changed), 'behavior')} into {folder}")
        _tell_of_change(chosen, *changed)


def reload(
    agents: Annotated[list[str] | None, typer.Argument()] = None, swarm: SwarmName = None
) -> None:
    """Make agents reload their libraries after a change by other means.

    The agents' behaviors begin again at Start.

    Args:
        agents: The agents. Default: all of the swarm.

    Example:
      hitab library reload keeper_1
    """
    done: list[tuple[str, str]] = []
    refused: list[tuple[str, str]] = []
    with connection(swarm) as swarm_up:
        for agent, text, did in swarm_up.agents.reload(agents or swarm_up.agents.await_agents()):
            (done if did else refused).append((agent, text))
    for text in each_once(done):
        console.say(text)
    if refused:
        raise SwarmError("\n".join(each_once(refused)))


def expect(
    name: Name,
    decision: Annotated[
        list[str] | None, typer.Argument(metavar="STATE NEXT_STATE [FEATURE=VALUE]...")
    ] = None,
    example: Annotated[int, typer.Option(show_default=False)] = 0,
    called_so: Annotated[str, typer.Option("--name", metavar="NAME")] = "",
    blocks: Annotated[bool, typer.Option("--blocks")] = False,
    forget: Annotated[str, typer.Option(metavar="NAME")] = "",
    library: Library = None,
    agent: Agent = None,
    swarm: SwarmName = None,
) -> None:
    """Add an expectation to a behavior: in a state and situation, it must go to a given state.

    Whenever the behavior is tested in a training, saved, distributed, reloaded, or checked, each
    broken expectation is reported with the actual decision.

    Args:
        decision: The state, the expected next state (or the same), and the situation; angles in
            degrees.
        example: Take the situation and decision of this example instead.
        called_so: Name of the expectation.
        blocks: Do not save the behavior while the expectation is broken.
        forget: Remove this expectation.

    Examples:
      hitab library expect Chase GoFast TurnToBall "DirectionTo(ball)=150" --agent keeper_1
      hitab library expect Chase --example 7 --blocks --agent keeper_1
      hitab library expect Chase --forget expectation_1 --agent keeper_1
    """
    from dataclasses import replace

    from hitab_bringup import expected, forgotten

    chosen = opened(library, agent, swarm, name)
    chosen.load()
    file = chosen.file(name)
    if forget:
        kept = forgotten(file, forget)
    else:
        new = expected(file, chosen.domain, decision or [], example, called_so)
        kept = [*file.expectations, replace(new, blocks=blocks)]
    saved = chosen.expect(name, kept)
    console.say(f"{name} carries {quantity(len(saved.expectations), 'expectation')}")
    _tell_of_change(chosen, name)


def tell_broken(library: BehaviorLibrary, *names: str) -> None:
    """Report broken expectations of behaviors of a library."""
    for name in names:
        for text in library.file(name).broken:
            console.note(f"but: {text}")


def _tell_of_change(library: BehaviorLibrary, *names: str) -> None:
    """Report expectations that changed behaviors break; make the library's agents reload it."""
    from hitab_bringup import users_of

    tell_broken(library, *names)
    for swarm, agents in users_of(library.folder):
        answers: list[tuple[str, str]] = []
        try:
            with connection(swarm) as swarm_up:
                answers += [(agent, text) for agent, text, _ in swarm_up.agents.reload(agents)]
        except SwarmError as error:
            answers.append((swarm, f"{error.what}; its agents have not read the change"))
        for text in each_once(answers):
            console.say(f"read again: {text}")
