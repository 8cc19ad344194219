"""Opening of library folders, whose files name their domain."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from hitab_commander import KIND_FILE, read_kind
from hitab_commander.commander_domain import commander_domain
from hitab_core import BehaviorLibrary, HitabError, LibraryError, named_domain
from hitab_core.library import BEHAVIOR_SUFFIX
from hitab_core.library.yaml_places import open_yaml


def open_library(folder: Path) -> BehaviorLibrary:
    """Return the library in a folder; only the domain of one file is read.

    A library of commanders also has a file that describes their kind.

    Raises:
        LibraryError: if there is no folder, or no file in the folder names its domain.
        VocabularyError: if the domain is not installed.
    """
    if not folder.is_dir():
        raise LibraryError(f"{folder}: there is no such library folder")
    kind = folder / KIND_FILE
    if kind.exists():
        return BehaviorLibrary(folder, commander_domain(read_kind(kind)))
    name = domain_in(folder)
    if name is None:
        raise LibraryError(_without_domain(folder))
    return BehaviorLibrary(folder, named_domain(name))


def domain_in(folder: Path) -> str | None:
    """Return the name of a library's domain; None if no file names it.

    The domain of a library of commanders is the name of their kind.
    """
    kind = folder / KIND_FILE
    if kind.exists():
        return read_kind(kind).name
    return next(filter(None, map(_domain_of, _behavior_files(folder))), None)


def _behavior_files(folder: Path) -> Iterator[Path]:
    """Yield the behavior files, then their kept versions, the newest first."""
    yield from sorted(folder.glob(f"*{BEHAVIOR_SUFFIX}"))
    yield from sorted(folder.glob(f".versions/*/*{BEHAVIOR_SUFFIX}"), reverse=True)


def _domain_of(path: Path) -> str | None:
    try:
        name = open_yaml(path).value["domain"]["name"]
    except (HitabError, TypeError, KeyError):
        return None  # another file may name the domain; loading reports the faults of this one
    return name if isinstance(name, str) else None


def _without_domain(folder: Path) -> str:
    """Return why a folder cannot be opened."""
    wrong = []
    for path in sorted(folder.glob(f"*{BEHAVIOR_SUFFIX}")):
        try:
            open_yaml(path)
            wrong.append(f"{path}: does not name its domain; restore it from a copy")
        except LibraryError as error:
            wrong.append(str(error))
    return (
        "\n".join(wrong)
        or f"{folder}: has no behaviors (files whose names end in {BEHAVIOR_SUFFIX})"
    )
