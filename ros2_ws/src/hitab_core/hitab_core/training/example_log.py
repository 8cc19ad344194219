"""The examples of one training and the history of edits, for undo and redo."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto

from hitab_core.errors import TrainingError
from hitab_core.example import Example, ExampleKind
from hitab_core.vocabulary import has
from hitab_core.wording import quantity

Placed = tuple[int, Example]
"""An example and its index in the list."""

NUMBERS_MAX = 6
"""The description of an edit with more examples gives their number instead of listing them."""


class Direction(Enum):
    """Whether an edit is new, an undo or a redo."""

    NEW = auto()
    UNDO = auto()
    REDO = auto()


@dataclass(frozen=True, slots=True)
class Edit:
    """A change of the examples, stored as a difference.

    Attributes:
        gone: removed examples with their indices before the edit, ascending.
        came: added examples with their indices after the edit, ascending.
        left, entered: labels of the states before and after a command; None if the edit is not a
            command. An undo swaps them.
        direction: whether it is new, an undo or a redo.
    """

    gone: tuple[Placed, ...] = ()
    came: tuple[Placed, ...] = ()
    left: str | None = None
    entered: str | None = None
    direction: Direction = Direction.NEW

    @property
    def undone(self) -> Edit:
        """The edit that undoes this one."""
        return Edit(self.came, self.gone, self.entered, self.left, Direction.UNDO)

    def __str__(self) -> str:
        """Describe it for people, as in ``Start → GoFast, 2 examples``."""
        if self.entered is not None:
            return f"{self.left} → {self.entered}, {quantity(len(self.came), 'example')}"
        verb = "changed" if self.came else "deleted"
        place = f" to {self.came[0][1].next_state}" if self.came else ""
        numbers = [example.number for _, example in self.gone]
        if not numbers:
            return "nothing"
        if len(numbers) > NUMBERS_MAX:
            return f"{verb} {quantity(len(numbers), 'example')}{place}"
        noun = "example" if len(numbers) == 1 else "examples"
        return f"{verb} {noun} {', '.join(map(str, numbers))}{place}"

    def apply(self, examples: list[Example]) -> None:
        """Apply it to a list."""
        for place, _ in reversed(self.gone):
            del examples[place]
        for place, example in self.came:
            examples.insert(place, example)


class ExampleLog:
    """Examples in the order of recording.

    An edit is first prepared, which refuses the impossible and changes nothing, and then made by
    `make`. The history holds differences, so it grows with the edits, not with the number of
    examples.
    """

    def __init__(self, examples: Iterable[Example] = ()) -> None:
        self._examples = list(examples)
        self._told: tuple[Example, ...] | None = None
        self._done: list[Edit] = []
        self._undone: list[Edit] = []
        self._defaults = sum(example.is_default for example in self._examples)
        self._next_number = 1 + max((e.number for e in self._examples), default=0)
        self._next_command = 1 + max((e.command for e in self._examples), default=0)

    @property
    def examples(self) -> tuple[Example, ...]:
        """All current examples."""
        if self._told is None:
            self._told = tuple(self._examples)
        return self._told

    def __len__(self) -> int:
        return len(self._examples)

    @property
    def defaults(self) -> int:
        """The number of default examples."""
        return self._defaults

    @property
    def done(self) -> list[str]:
        """Descriptions of what can be undone, oldest first."""
        return [str(edit) for edit in self._done]

    @property
    def undone(self) -> list[str]:
        """Descriptions of what can be redone, oldest first; redo begins with the first."""
        return [str(edit) for edit in reversed(self._undone)]

    def preview(
        self,
        state: str,
        features: tuple[float, ...],
        next_state: str,
        *,
        kind: ExampleKind,
        with_default: bool,
        cycle: int = 0,
    ) -> list[Example]:
        """Return the numbered examples that a command teaches, without adding them."""
        command = self._next_command
        taught = [Example(state, features, next_state, kind, self._next_number, command, cycle)]
        if with_default:
            number = self._next_number + 1
            taught.append(
                replace(taught[0], state=next_state, kind=ExampleKind.DEFAULT, number=number)
            )
        return taught

    # -- preparing --------------------------------------------------------------------------

    def addition(self, taught: Sequence[Example]) -> Edit:
        """Prepare to add what a command taught; its first example gives the states."""
        came = tuple(enumerate(taught, len(self._examples)))
        if not taught:
            return Edit()
        return Edit((), came, taught[0].state, taught[0].next_state)

    def deletion(self, numbers: Iterable[int]) -> Edit:
        """Prepare to delete examples.

        Raises:
            TrainingError: if one of the numbers is unknown.
        """
        return Edit(self._known(numbers))

    def relabelling(self, numbers: Iterable[int], next_state: str) -> Edit:
        """Prepare to change the next state of examples; a default example becomes an ordinary one.

        Raises:
            TrainingError: if one of the numbers is unknown.
        """
        chosen = tuple(p for p in self._known(numbers) if p[1].next_state != next_state)
        changed = tuple(
            (
                place,
                replace(
                    e,
                    next_state=next_state,
                    kind=ExampleKind.CORRECTION if e.is_default else e.kind,
                ),
            )
            for place, e in chosen
        )
        return Edit(chosen, changed)

    def undoing(self) -> Edit:
        """Prepare to undo the last addition, deletion or relabelling.

        Raises:
            TrainingError: if there is nothing to undo.
        """
        if not self._done:
            raise TrainingError("nothing to undo")
        return self._done[-1].undone

    def redoing(self) -> Edit:
        """Prepare to redo what was undone last.

        Raises:
            TrainingError: if nothing was undone, or a new edit came after it.
        """
        if not self._undone:
            raise TrainingError("nothing to redo: nothing was undone, or a new edit came after it")
        return replace(self._undone[-1], direction=Direction.REDO)

    # -- doing ------------------------------------------------------------------------------

    def add(self, taught: Sequence[Example]) -> None:
        """Add what one command taught."""
        self.make(self.addition(taught))

    def after(self, edit: Edit) -> tuple[Example, ...]:
        """Return the examples as they would be after an edit."""
        examples = list(self._examples)
        edit.apply(examples)
        return tuple(examples)

    def make(self, edit: Edit) -> None:
        """Make a prepared edit; no other edit may come in between."""
        edit.apply(self._examples)
        self._told = None
        self._defaults += sum(e.is_default for _, e in edit.came)
        self._defaults -= sum(e.is_default for _, e in edit.gone)
        match edit.direction:
            case Direction.UNDO:
                self._undone.append(self._done.pop())
            case Direction.REDO:
                self._done.append(self._undone.pop())
            case Direction.NEW:
                self._done.append(edit)
                self._undone.clear()
                self._next_number = max((self._next_number, *(e.number + 1 for _, e in edit.came)))
                self._next_command = max(
                    (self._next_command, *(e.command + 1 for _, e in edit.came))
                )

    def _known(self, numbers: Iterable[int]) -> tuple[Placed, ...]:
        wanted = set(numbers)
        there = {e.number for e in self._examples}
        if not wanted:
            raise TrainingError(f"no example numbers given {has(there)}")
        for number in sorted(wanted - there):
            raise TrainingError(f"no example number {number} {has(there)}")
        return tuple((i, e) for i, e in enumerate(self._examples) if e.number in wanted)
