"""The journal of an agent's training, from its beginning until it is saved or discarded."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from hitab_core.errors import FolderInUseError, HitabError, LibraryError, TrainingError
from hitab_core.example import Example
from hitab_core.example_codec import example_record
from hitab_core.training.curriculum import Curriculum
from hitab_core.training.example_journal import ExampleJournal, archive
from hitab_core.use import Use

JOURNAL_FILE = "training.jsonl"

RESUMED = "resume"
"""Journal entry for the moment at which another process resumes a training."""

Record = Mapping[str, Any]

T = TypeVar("T")


class TrainingJournal:
    """Keeps the current training on disk, where it survives the process.

    Without a folder it keeps nothing.

    Attributes:
        path: of the file; None if it keeps nothing.
        damage: why the training on disk cannot be resumed, and the way out; empty if none is
            there, or it was resumed.
    """

    def __init__(self, folder: Path | None, domain: str) -> None:
        """Name the journal; nothing is read or written yet.

        Args:
            folder: of the journal; None to keep no journal.
            domain: name of the agent's domain.
        """
        self.path = None if folder is None else folder / JOURNAL_FILE
        self.damage = ""
        self._domain = domain
        self._file: ExampleJournal | None = None

    def begin(
        self, curriculum: Curriculum, examples: Iterable[Example], readable: Iterable[Use]
    ) -> None:
        """Begin the journal of a training, in place of the one before.

        Args:
            curriculum: what is trained.
            examples: to continue from.
            readable: names of all readings.

        Raises:
            LibraryError: if it cannot be written; then the one before is still there.
        """
        if self.path is None:
            return
        file = ExampleJournal.begin(
            self.path,
            {
                "do": "begin",
                "domain": self._domain,
                "curriculum": curriculum.to_record(),
                "examples": [example_record(e) for e in examples],
                "readable": [str(use) for use in readable],
                "at": time.time(),
            },
        )
        self.close()
        self._file, self.damage = file, ""

    def write(self, record: Mapping[str, object]) -> None:
        """Write what was done; it is on disk when this returns.

        Raises:
            LibraryError: if it cannot be written.
        """
        if self._file is not None:
            self._file.append({**record, "at": time.time()})

    @property
    def is_open(self) -> bool:
        """Whether this process keeps a training in it."""
        return self._file is not None

    def discard(self) -> None:
        """Archive the journal of a training that is given up.

        Raises:
            LibraryError: if it cannot be moved.
        """
        if self._file is not None:
            self._file.archive()
            self._file = None
        elif self.path is not None and self.damage:
            archive(self.path)
        self.damage = ""

    def archive(self) -> None:
        """Archive the journal of a saved training; if that fails, the next start does it."""
        file, self._file = self._file, None
        if file is not None:
            with suppress(LibraryError):
                file.archive()
            file.close()

    def close(self) -> None:
        """Close the file; it stays where it is."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def resume(
        self, replay: Callable[[Sequence[Record]], T], has_saved: Callable[[str, str], bool]
    ) -> T | None:
        """Return the interrupted training; None if there is none, or `damage` says why not.

        Args:
            replay: makes it again from its records.
            has_saved: whether the library has a behavior of this name and checksum.

        Raises:
            FolderInUseError: if another process uses it.
        """
        self.damage = ""
        if self.path is None or not self.path.exists():
            return None
        try:
            return self._resumed(ExampleJournal.open(self.path), replay, has_saved)
        except FolderInUseError:
            raise
        except LibraryError as error:
            self.damage = str(error)
            return None

    def _resumed(
        self,
        file: ExampleJournal,
        replay: Callable[[Sequence[Record]], T],
        has_saved: Callable[[str, str], bool],
    ) -> T | None:
        records = [record for record in file.records if record.get("do") != RESUMED]
        if not file.records:
            file.discard()
            return None
        last = records[-1] if records else {}
        saved = str(last.get("automaton")), str(last.get("checksum"))
        if last.get("do") == "save" and has_saved(*saved):
            # The process ended after saving the behavior and before archiving the journal.
            self._file = file
            self.archive()
            return None
        try:
            domain = records[0]["domain"]
            if domain != self._domain:
                raise TrainingError(
                    f'it is of domain "{domain}", and the agent has "{self._domain}"'
                )
            training = replay(records)
        except (HitabError, LookupError, TypeError, ValueError) as error:
            file.close()
            raise LibraryError(
                f"{self.path}: the interrupted training cannot be resumed: {error}; "
                "fix that, or move this file away to start without that training"
            ) from error
        self._file = file
        with suppress(LibraryError):  # only what the training took depends on it
            self.write({"do": RESUMED})
        return training
