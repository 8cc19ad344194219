"""The export of a behavior from a library to a language."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from hitab_core import BehaviorLibrary, Term, VocabularyError, unknown
from hitab_core.library import bundle_digest, tool_name
from hitab_export.behavior_tree import as_behavior_tree
from hitab_export.cpp import as_cpp
from hitab_export.hierarchy_form import Hierarchy, hierarchy_of
from hitab_export.python import as_python


class Language(NamedTuple):
    """A target language: its writer, given a behavior and its origin, and its file ending."""

    write: Callable[[Hierarchy, str], str]
    suffix: str
    has_numbers: bool = False


LANGUAGES: Mapping[str, Language] = MappingProxyType(
    {
        "python": Language(as_python, ".py", has_numbers=True),
        "cpp": Language(as_cpp, ".hpp"),
        "bt.xml": Language(as_behavior_tree, ".bt.xml"),
    }
)


def exported(library: BehaviorLibrary, behavior: str, to: str) -> str:
    """Return a behavior, with all its parts, as a program without HiTAB.

    Args:
        library: source of the behavior.
        behavior: name with a target for each parameter, such as ``Chase(ball)``.
        to: one of `LANGUAGES`.

    Raises:
        VocabularyError: if there is no such behavior or language, or if a part of the behavior
            cannot be exported; the error names the part.
        LibraryError: if the library cannot be read.
    """
    if to not in LANGUAGES:
        raise VocabularyError(unknown("language", to, LANGUAGES))
    loaded, term = library.loaded(strict=False), Term.parse(behavior)
    hierarchy = hierarchy_of(loaded.repertoire, term)
    if not LANGUAGES[to].has_numbers:
        _refuse_numbers(hierarchy, to)
    parts = [name for name in loaded.repertoire.needed_by(term.name) if name in loaded.files]
    digest = bundle_digest(tuple((name, loaded.files[name].text) for name in parts))
    origin = (
        f"{term}, exported by {tool_name()} from the library "
        f"{library.folder.resolve().name} of domain {library.domain.name}, "
        f"version {library.domain.version}.\n"
        f"Digest of {', '.join(parts)}:\n{digest}"
    )
    return LANGUAGES[to].write(hierarchy, origin)


def _refuse_numbers(hierarchy: Hierarchy, to: str) -> None:
    for automaton in hierarchy.automata:
        for state in automaton.states:
            if state.numbers is not None:
                raise VocabularyError(
                    f'"{automaton.term.name}" cannot be exported to {to}: "{state.label}" in it '
                    "takes numbers; export it to python, or have HiTAB perform it"
                )
