"""Opens a library folder; its files name their domain."""

from __future__ import annotations

from pathlib import Path

from hitab_commander import KIND_FILE, read_kind
from hitab_commander.commander_domain import commander_domain
from hitab_core import BehaviorLibrary, HitabError, LibraryError, load_domain
from hitab_core.library import SUFFIX
from hitab_core.library.yaml_places import open_yaml


def open_library(folder: Path) -> BehaviorLibrary:
    """Return the library in a folder, having read only one file's domain.

    A library of commanders also has a file that describes their kind.

    Raises:
        LibraryError: if there is no folder, or no behavior in it.
        VocabularyError: if its domain is not installed.
    """
    if not folder.is_dir():
        raise LibraryError(f"{folder}: there is no such library folder")
    name = None
    for path in sorted(folder.glob(f"*{SUFFIX}")):
        name = name or _domain_of(path)
    kind = folder / KIND_FILE
    if kind.exists():
        return BehaviorLibrary(folder, commander_domain(read_kind(kind)))
    if name is None:
        raise LibraryError(f"{folder}: has no behaviors (files whose names end in {SUFFIX})")
    return BehaviorLibrary(folder, load_domain(name))


def _domain_of(path: Path) -> str | None:
    try:
        name = open_yaml(path).value["domain"]["name"]
    except (HitabError, TypeError, KeyError):
        return None  # another file may name it; loading reports what is wrong with this one
    return name if isinstance(name, str) else None
