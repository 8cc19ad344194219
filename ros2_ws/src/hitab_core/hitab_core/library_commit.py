"""Several files of a folder changed at once: all of them, or none, also when the power fails.

What is to be done is first written down whole in one file; from then on it will be done. Whoever
comes to the folder next and finds that file does it again from the beginning.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path

from hitab_core.durable_files import (
    UNFINISHED,
    file_errors,
    make_folder,
    sync_folder,
    write_durably,
)
from hitab_core.errors import LibraryError

COMMIT = ".commit.json"
"""The file that says what is to be done."""

_INSIDE = re.compile(r"(\.?[A-Za-z0-9][A-Za-z0-9_.-]*/)*\.?[A-Za-z0-9][A-Za-z0-9_.-]*\Z")


def commit(folder: Path, changes: Mapping[str, bytes | None]) -> None:
    """Write and remove files, all or none. The caller holds the folder alone.

    Args:
        folder: where.
        changes: new contents by path inside the folder; None: the file is removed.

    Raises:
        LibraryError: if it cannot be written; then nothing has changed, or, where the disk fails
            in the middle, the rest is done by `finish` later.
    """
    finish(folder)
    plan = {
        path: None if data is None else data.decode("latin-1") for path, data in changes.items()
    }
    with file_errors(folder, "write to"):
        write_durably(folder / COMMIT, json.dumps(plan).encode())
    finish(folder)


def is_unfinished(folder: Path) -> bool:
    """Return whether changes are written down but perhaps not all done."""
    return (folder / COMMIT).exists()


def finish(folder: Path) -> None:
    """Do what is written down, if anything is. The caller holds the folder alone.

    Raises:
        LibraryError: if what is written down makes no sense, or cannot be done.
    """
    note = folder / COMMIT
    with file_errors(folder, "write to"):
        for inner in ("", ".*/*/"):  # beside the behaviors and beside their versions
            for left_over in folder.glob(f"{inner}.*{UNFINISHED}"):
                left_over.unlink(missing_ok=True)
        if not note.exists():
            return
        for path, content in _plan(note).items():
            place = folder / path
            if content is not None:
                write_durably(place, content.encode("latin-1"))
            elif place.exists():
                place.unlink()
                sync_folder(place.parent)
        make_folder(folder)
        note.unlink()
        sync_folder(folder)


def _plan(note: Path) -> dict[str, str | None]:
    try:
        plan = json.loads(note.read_bytes())
        for path, content in plan.items():
            if _INSIDE.match(path) is None or not isinstance(content, str | None):
                raise ValueError(path)
            (content or "").encode("latin-1")
    except (ValueError, AttributeError, TypeError, RecursionError) as error:
        raise LibraryError(
            f"{note}: does not say what is to be done ({error}); "
            "it was changed by hand: remove it and check the folder's files"
        ) from None
    checked: dict[str, str | None] = plan
    return checked
