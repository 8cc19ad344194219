"""A behavior and everything it is made of, to send to other agents: all or none."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from hitab_core.hierarchy import in_order
from hitab_core.library.behavior_file import BehaviorFile
from hitab_core.library.change import LibraryChange
from hitab_core.library.check import misfits
from hitab_core.library.loaded_library import LibraryReader, LoadedLibrary
from hitab_core.repertoire import Repertoire
from hitab_core.texts.errors import LibraryError, VocabularyError
from hitab_core.texts.vocabulary import has


@dataclass(frozen=True, slots=True)
class Bundle:
    """Behavior files, each after its parts; the last is the behavior to send.

    Attributes:
        files: pairs of behavior name and file text.
        digest: SHA-256, in hexadecimal, of all files.
    """

    files: tuple[tuple[str, str], ...]
    digest: str

    @property
    def name(self) -> str:
        """The behavior to send; empty if there is none."""
        return self.files[-1][0] if self.files else ""


def bundle_digest(files: tuple[tuple[str, str], ...]) -> str:
    """Return the digest of names and texts, in order."""
    whole = hashlib.sha256()
    for name, text in files:
        for part in (name, text):
            data = part.encode(errors="surrogatepass")
            whole.update(b"%d:" % len(data) + data)
    return whole.hexdigest()


def make_bundle(texts: Mapping[str, str], repertoire: Repertoire, name: str) -> Bundle:
    """Pack a behavior.

    Args:
        texts: texts of the files of trained behaviors, by name.
        repertoire: repertoire that these behaviors use.
        name: name of the behavior.

    Raises:
        LibraryError: if the behavior, or a part of it, has not been saved.
    """
    try:
        needed = repertoire.needed_by(name)
    except VocabularyError as error:
        raise LibraryError(f'"{name}" cannot be sent: {error}') from None
    files = []
    for part in needed:
        if part in texts:
            files.append((part, texts[part]))
        elif repertoire.automata[part] is not repertoire.domain.automata.get(part):
            raise LibraryError(
                f'"{name}" cannot be sent: "{part}" has no file {has(texts)}; save it first'
            )
    if not files:
        raise LibraryError(
            f'"{name}" does not need to be sent: it comes with domain "{repertoire.domain.name}"'
        )
    made = tuple(files)
    return Bundle(made, bundle_digest(made))


def plan_bundle(change: LibraryChange, bundle: Bundle) -> LoadedLibrary:
    """Plan to add the behaviors of a bundle to a library: all or none.

    A sound copy of a lost behavior brings it back, and all that is made of it.

    Returns:
        The library as loaded after the change.

    Raises:
        LibraryError: naming every fault of it, or other behaviors that could no longer be used.
        VocabularyError: if they do not fit the domain.
    """
    change.install(dict(bundle.files))
    return change.loaded()


def digest_in(loaded: LoadedLibrary, names: Iterable[str]) -> str:
    """Return the digest of these behaviors' files in a loaded library, in the order given."""
    return bundle_digest(tuple((name, loaded.files[name].text) for name in names))


def read_bundle(bundle: Bundle, reader: LibraryReader) -> dict[str, BehaviorFile]:
    """Return the files of a bundle by name, each after its parts.

    Args:
        bundle: the received bundle.
        reader: reads the files, and caches them.

    Raises:
        LibraryError: naming everything wrong with it.
    """
    if not bundle.files:
        raise LibraryError("the bundle is empty; send it again")
    found = bundle_digest(bundle.files)
    if found != bundle.digest:
        raise LibraryError(
            f'the bundle of "{bundle.name}" has digest {found[:16]}… instead of '
            f"{bundle.digest[:16]}…: it was corrupted in transit; send it again"
        )
    files = reader.read_all(dict(bundle.files))
    problems = list(misfits(files, reader.domain)[0].values())
    if not problems and not _is_well_packed(bundle, files):
        problems.append(
            f'"{bundle.name}" is not packed with all of its parts and nothing else, each once '
            "and after its own parts; pack it again"
        )
    if problems:
        raise LibraryError("\n".join(problems))
    return files


def _is_well_packed(bundle: Bundle, files: Mapping[str, BehaviorFile]) -> bool:
    def uses(name: str) -> frozenset[str]:
        return files[name].automaton.behaviors_used & {*files}

    names = [name for name, _ in bundle.files]
    made_of = in_order([bundle.name], uses)
    in_turn = all(uses(name) <= {*names[:place]} for place, name in enumerate(names))
    return sorted(names) == sorted(made_of) and in_turn
