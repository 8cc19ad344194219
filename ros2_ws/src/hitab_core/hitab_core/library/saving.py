"""Saving: the behavior that a training adds to a library, and the library as loaded afterwards."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from hitab_core.automaton import Automaton
from hitab_core.library.behavior_file import BehaviorFile
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.library.change import LibraryChange
from hitab_core.library.loaded_library import LoadedLibrary
from hitab_core.texts.errors import VocabularyError


class SavedBehavior(NamedTuple):
    """A training that was saved.

    Attributes:
        automaton: the learned automaton.
        path: path of its file.
        notes: notes on trimmed states and features and on stopped behaviors.
        replaced: its version number and the replaced version, in words; empty if there is none.
    """

    automaton: Automaton
    path: Path
    notes: list[str]
    replaced: str


def loaded_with(
    saved: BehaviorFile, change: LibraryChange, library: BehaviorLibrary, known: LoadedLibrary
) -> LoadedLibrary:
    """Return the loaded library that an agent knows after a change that saves a behavior.

    Raises:
        VocabularyError: if the behavior does not fit the library.
    """
    losses = known.losses
    try:
        if losses and change.contents.problems.keys() <= losses.reasons.keys():
            return change.loaded()  # lost behaviors may be usable again
        # Other agents' additions to a shared library are picked up on reload.
        return library.reader.of({**known.files, saved.name: saved}, losses)
    except VocabularyError as error:
        raise VocabularyError(
            f'"{saved.name}" cannot be saved: {error}; save it under another name, or '
            "first retrain what uses it"
        ) from None
