"""The examples of one training with everything that was done to them, so that it can be undone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from hitab_core.errors import TrainingError, has
from hitab_core.example import Example, ExampleKind


class ExampleLog:
    """Examples in the order in which they were recorded, with undo."""

    def __init__(self, examples: Iterable[Example] = ()) -> None:
        self._examples: tuple[Example, ...] = tuple(examples)
        self._history: list[tuple[Example, ...]] = []
        self._next_number = 1 + max((e.number for e in self._examples), default=0)
        self._next_command = 1 + max((e.command for e in self._examples), default=0)

    @property
    def examples(self) -> tuple[Example, ...]:
        """All examples there are now."""
        return self._examples

    def __len__(self) -> int:
        return len(self._examples)

    @property
    def defaults(self) -> int:
        """How many of them are default examples."""
        return sum(example.is_default for example in self._examples)

    @property
    def can_undo(self) -> bool:
        """Whether there is something to take back."""
        return bool(self._history)

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

    def add(self, taught: Sequence[Example]) -> None:
        """Add what one command taught."""
        self._change((*self._examples, *taught))
        self._next_number = max((self._next_number, *(e.number + 1 for e in taught)))
        self._next_command = max((self._next_command, *(e.command + 1 for e in taught)))

    def delete(self, numbers: Iterable[int]) -> None:
        """Delete examples.

        Raises:
            TrainingError: if one of the numbers is not there; then nothing is deleted.
        """
        doomed = self._known(numbers)
        self._change(tuple(e for e in self._examples if e.number not in doomed))

    def relabel(self, numbers: Iterable[int], next_state: str) -> None:
        """Change where examples lead to. A relabelled default example becomes an ordinary one.

        Raises:
            TrainingError: if one of the numbers is not there; then nothing is changed.
        """
        chosen = self._known(numbers)
        self._change(
            tuple(
                replace(
                    e,
                    next_state=next_state,
                    kind=ExampleKind.CORRECTION if e.is_default else e.kind,
                )
                if e.number in chosen and e.next_state != next_state
                else e
                for e in self._examples
            )
        )

    def undo(self) -> None:
        """Take back the last addition, deletion or relabelling.

        Raises:
            TrainingError: if there is nothing to take back.
        """
        if not self._history:
            raise TrainingError("nothing to undo")
        self._examples = self._history.pop()

    def _known(self, numbers: Iterable[int]) -> set[int]:
        wanted = set(numbers)
        there = {e.number for e in self._examples}
        if not wanted:
            raise TrainingError(f"no example numbers given {has(there)}")
        for number in sorted(wanted - there):
            raise TrainingError(f"no example number {number} {has(there)}")
        return wanted

    def _change(self, examples: tuple[Example, ...]) -> None:
        self._history.append(self._examples)
        self._examples = examples
