"""Undo and redo: an edit of a training's examples, and the history of edits."""

from __future__ import annotations

from bisect import bisect_left, insort
from dataclasses import dataclass, replace
from enum import Enum, auto
from operator import attrgetter

from hitab_core.example import Example
from hitab_core.texts.errors import TrainingError

NUMBER = attrgetter("number")


class Direction(Enum):
    """Whether an edit is new, an undo or a redo."""

    NEW = auto()
    UNDO = auto()
    REDO = auto()


@dataclass(frozen=True, slots=True)
class Edit:
    """A change of the examples, stored as a difference.

    Attributes:
        words: the effect, for people, as in ``Start → GoFast, 2 examples``.
        gone: removed examples, and changed ones as they were, by number.
        came: added examples, and changed ones as they are then, by number.
        left, entered: labels of the states before and after a command; None if the edit is not a
            command. An undo swaps them.
        features: names of the features after the edit; None if unchanged.
        features_before: names of the features before it; None if unchanged.
        direction: whether it is new, an undo or a redo.
    """

    words: str = "nothing"
    gone: tuple[Example, ...] = ()
    came: tuple[Example, ...] = ()
    left: str | None = None
    entered: str | None = None
    features: tuple[str, ...] | None = None
    features_before: tuple[str, ...] | None = None
    direction: Direction = Direction.NEW

    @property
    def undone(self) -> Edit:
        """The edit that undoes this one."""
        return replace(
            self,
            gone=self.came,
            came=self.gone,
            left=self.entered,
            entered=self.left,
            features=self.features_before,
            features_before=self.features,
            direction=Direction.UNDO,
        )

    def apply(self, examples: list[Example]) -> None:
        """Apply the edit to a list that is sorted by number."""
        for example in reversed(self.gone):
            del examples[bisect_left(examples, example.number, key=NUMBER)]
        for example in self.came:
            insort(examples, example, key=NUMBER)


class History:
    """The edits that were made, and those that were undone since the last new one."""

    def __init__(self) -> None:
        self._done: list[Edit] = []
        self._undone: list[Edit] = []

    @property
    def done(self) -> list[str]:
        """Descriptions of what can be undone, oldest first."""
        return [edit.words for edit in self._done]

    @property
    def undone(self) -> list[str]:
        """Descriptions of what can be redone, oldest first; redo begins with the first."""
        return [edit.words for edit in reversed(self._undone)]

    def undo(self) -> Edit:
        """Return the edit that undoes the last addition, deletion or relabeling.

        Raises:
            TrainingError: if there is nothing to undo.
        """
        if not self._done:
            raise TrainingError("nothing to undo")
        return self._done[-1].undone

    def redo(self) -> Edit:
        """Return the edit that redoes what was undone last.

        Raises:
            TrainingError: if nothing was undone, or a new edit came after it.
        """
        if not self._undone:
            raise TrainingError("nothing to redo: nothing was undone, or a new edit came after it")
        return replace(self._undone[-1], direction=Direction.REDO)

    def add(self, edit: Edit) -> None:
        """Keep an edit that was made."""
        match edit.direction:
            case Direction.UNDO:
                self._undone.append(self._done.pop())
            case Direction.REDO:
                self._done.append(self._undone.pop())
            case Direction.NEW:
                self._done.append(edit)
                self._undone.clear()
