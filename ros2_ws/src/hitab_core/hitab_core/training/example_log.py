"""The examples of one training with what was done to them, so that it can be undone and redone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto

from hitab_core.errors import TrainingError, has
from hitab_core.example import Example, ExampleKind

Placed = tuple[int, Example]
"""An example and its place among the others."""


class Direction(Enum):
    """How an edit stands to the history."""

    NEW = auto()
    UNDO = auto()
    REDO = auto()


@dataclass(frozen=True, slots=True)
class Edit:
    """Something done to the examples: only the difference that it makes.

    Attributes:
        gone: what it takes away, by the places before it, ascending.
        came: what it puts in, by the places after it, ascending.
        left, entered: labels of the state in which a command was given and of the one that it
            led to; None for edits that are no commands. Undone, these are swapped.
        direction: whether it is new, or one of the history is undone or redone.
    """

    gone: tuple[Placed, ...] = ()
    came: tuple[Placed, ...] = ()
    left: str | None = None
    entered: str | None = None
    direction: Direction = Direction.NEW

    @property
    def undone(self) -> Edit:
        """The edit that takes this one back."""
        return Edit(self.came, self.gone, self.entered, self.left, Direction.UNDO)

    def apply(self, examples: list[Example]) -> None:
        """Do it to a list."""
        for place, _ in reversed(self.gone):
            del examples[place]
        for place, example in self.came:
            examples.insert(place, example)


class ExampleLog:
    """Examples in the order in which they were recorded.

    What is to be done is prepared, which refuses what cannot be done and changes nothing, and
    then done by `make`. The history holds differences: it grows with what was done, not with how
    many examples there were.
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
        """All examples there are now."""
        if self._told is None:
            self._told = tuple(self._examples)
        return self._told

    def __len__(self) -> int:
        return len(self._examples)

    @property
    def defaults(self) -> int:
        """How many of them are default examples."""
        return self._defaults

    @property
    def can_undo(self) -> bool:
        """Whether there is something to take back."""
        return bool(self._done)

    @property
    def can_redo(self) -> bool:
        """Whether there is something to do again."""
        return bool(self._undone)

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
        """Return the examples that one command teaches, numbered, without adding them."""
        command = self._next_command
        taught = [Example(state, features, next_state, kind, self._next_number, command, cycle)]
        if with_default:
            taught.append(
                Example(
                    next_state,
                    features,
                    next_state,
                    ExampleKind.DEFAULT,
                    self._next_number + 1,
                    command,
                    cycle,
                )
            )
        return taught

    # -- preparing --------------------------------------------------------------------------

    def addition(self, taught: Sequence[Example]) -> Edit:
        """Prepare to add what one command taught; its first example says where it led."""
        came = tuple(enumerate(taught, len(self._examples)))
        if not taught:
            return Edit()
        return Edit((), came, taught[0].state, taught[0].next_state)

    def deletion(self, numbers: Iterable[int]) -> Edit:
        """Prepare to delete examples.

        Raises:
            TrainingError: if one of the numbers is not there.
        """
        return Edit(self._known(numbers))

    def relabelling(self, numbers: Iterable[int], next_state: str) -> Edit:
        """Prepare to change where examples lead to; a default example becomes an ordinary one.

        Raises:
            TrainingError: if one of the numbers is not there.
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
        """Prepare to take back the last addition, deletion or relabelling.

        Raises:
            TrainingError: if there is nothing to take back.
        """
        if not self._done:
            raise TrainingError("nothing to undo")
        return self._done[-1].undone

    def redoing(self) -> Edit:
        """Prepare to do again what was undone last.

        Raises:
            TrainingError: if there is nothing, or something new was done since.
        """
        if not self._undone:
            raise TrainingError("nothing to redo: nothing was undone, or something was done since")
        return replace(self._undone[-1], direction=Direction.REDO)

    # -- doing ------------------------------------------------------------------------------

    def add(self, taught: Sequence[Example]) -> None:
        """Add what one command taught."""
        self.make(self.addition(taught))

    def after(self, edit: Edit) -> tuple[Example, ...]:
        """Return the examples that there would be."""
        examples = list(self._examples)
        edit.apply(examples)
        return tuple(examples)

    def make(self, edit: Edit) -> None:
        """Do what was prepared, with nothing done in between."""
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
