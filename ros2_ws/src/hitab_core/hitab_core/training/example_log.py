"""The examples of one training and the history of edits, for undo and redo."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto

from hitab_core.errors import TrainingError
from hitab_core.example import Example, ExampleKind, superseding
from hitab_core.vocabulary import has
from hitab_core.wording import numbered, quantity

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
        words: what it does, for people, as in ``Start → GoFast, 2 examples``.
        gone: removed examples with their indices before the edit, ascending.
        came: added examples with their indices after the edit, ascending.
        left, entered: labels of the states before and after a command; None if the edit is not a
            command. An undo swaps them.
        features: names of the features after the edit; None: unchanged.
        features_before: names of the features before it; None: unchanged.
        direction: whether it is new, an undo or a redo.
    """

    words: str = "nothing"
    gone: tuple[Placed, ...] = ()
    came: tuple[Placed, ...] = ()
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

    def __str__(self) -> str:
        """Describe it for people."""
        return self.words

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
    examples. Each edit also marks the default examples that a command contradicts, or no longer
    does (`hitab_core.example.superseding`).

    Attributes:
        recorded: how many examples commands have added, whatever became of them.
    """

    def __init__(self, examples: Iterable[Example] = ()) -> None:
        self._examples = superseding(tuple(examples))
        self._told: tuple[Example, ...] | None = None
        self._done: list[Edit] = []
        self._undone: list[Edit] = []
        self._defaults = sum(example.is_default for example in self._examples)
        self._next_number = 1 + max((e.number for e in self._examples), default=0)
        self._next_command = 1 + max((e.command for e in self._examples), default=0)
        self.recorded = 0

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
        entered: tuple[float, ...] | None = None,
        cycle: int = 0,
        ago: float = 0.0,
        readings: tuple[float, ...] = (),
    ) -> list[Example]:
        """Return the numbered examples that a command teaches, without adding them.

        Args:
            state, features, next_state, kind, cycle, ago, readings: of the command's example.
            entered: the values of the default example; None: there is none.
        """
        command, number = self._next_command, self._next_number
        taught = [
            Example(state, features, next_state, kind, number, command, cycle, ago, readings)
        ]
        if entered is not None:
            kept = replace(taught[0], state=next_state, features=entered, number=number + 1)
            taught.append(replace(kept, kind=ExampleKind.DEFAULT))
        return taught

    # -- preparing --------------------------------------------------------------------------

    def addition(self, taught: Sequence[Example]) -> Edit:
        """Prepare to add what a command taught; its first example gives the states."""
        if not taught:
            return Edit()
        first = taught[0]
        words = f"{first.state} → {first.next_state}, {quantity(len(taught), 'example')}"
        return replace(
            self._edit([*self._examples, *taught], words),
            left=first.state,
            entered=first.next_state,
        )

    def answer(
        self, state: str, features: tuple[float, ...], next_state: str, kind: ExampleKind
    ) -> Edit:
        """Prepare to add the example that an answer to a question is."""
        example = Example(state, features, next_state, kind, self._next_number, self._next_command)
        return self._edit([*self._examples, example], f"answered {state} → {next_state}")

    def deletion(self, numbers: Iterable[int]) -> Edit:
        """Prepare to delete examples.

        Raises:
            TrainingError: if one of the numbers is unknown.
        """
        wanted = self._known(numbers)
        kept = [e for e in self._examples if e.number not in wanted]
        return self._edit(kept, f"deleted {these(wanted)}")

    def relabeling(self, numbers: Iterable[int], next_state: str) -> Edit:
        """Prepare to change the next state of examples; a default example becomes an ordinary one.

        Raises:
            TrainingError: if one of the numbers is unknown.
        """
        wanted = self._known(numbers)

        def changed(e: Example) -> Example:
            if e.number not in wanted or e.next_state == next_state:
                return e
            kind = ExampleKind.CORRECTION if e.is_default else e.kind
            return replace(e, next_state=next_state, kind=kind)

        after = [changed(e) for e in self._examples]
        really = [e.number for e, old in zip(after, self._examples, strict=True) if e is not old]
        return self._edit(after, f"changed {these(really)} to {next_state}" if really else "")

    def replacement(self, after: Sequence[Example], words: str) -> Edit:
        """Prepare to have other examples in place of some, with the same numbers.

        Args:
            after: all examples, in the same order, with some of them changed.
            words: what that does.
        """
        return self._edit(after, words)

    def _edit(self, after: Sequence[Example], words: str) -> Edit:
        """Return the difference to other examples in the same order, once these are marked."""
        marked = superseding(after)
        before = {e.number: e for e in self._examples}
        there = {e.number: e for e in marked}
        gone = tuple((i, e) for i, e in enumerate(self._examples) if there.get(e.number) is not e)
        came = tuple((i, e) for i, e in enumerate(marked) if before.get(e.number) is not e)
        superseded = [
            e.number
            for _, e in came
            if not e.is_learned and (e.number not in before or before[e.number].is_learned)
        ]
        if superseded:
            words += f"; superseded {these(superseded)}"
        return Edit(words or "nothing", gone, came)

    def undoing(self) -> Edit:
        """Prepare to undo the last addition, deletion or relabeling.

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
        self.recorded += sum(e.number >= self._next_number for _, e in edit.came)
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

    def commands_of(self, numbers: Iterable[int]) -> dict[int, int]:
        """Return the commands that examples were recorded by, each with one of these examples.

        Raises:
            TrainingError: if one of the numbers is unknown.
        """
        wanted = self._known(numbers)
        return {e.command: e.number for e in reversed(self._examples) if e.number in wanted}

    def _known(self, numbers: Iterable[int]) -> frozenset[int]:
        wanted = frozenset(numbers)
        there = {e.number for e in self._examples}
        if not wanted:
            raise TrainingError(f"no example numbers given {has(there)}")
        for number in sorted(wanted - there):
            raise TrainingError(f"no example number {number} {has(there)}")
        return wanted


def these(numbers: Iterable[int]) -> str:
    """Name examples by their numbers, unless they are many."""
    return numbered("example", numbers, NUMBERS_MAX)
