"""The examples of one training, and preparing and making edits of them."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from hitab_core.automaton import START
from hitab_core.codec import from_dict, values_of
from hitab_core.default_example import marked
from hitab_core.example import Example, ExampleKind, Place
from hitab_core.texts.errors import TrainingError
from hitab_core.texts.vocabulary import has
from hitab_core.texts.wording import numbered, quantity
from hitab_core.training.undo import NUMBER, Edit, History

NUMBERS_MAX = 6
"""The description of an edit with more examples gives their number instead of listing them."""


class ExampleLog:
    """Examples in the order of recording, which is the order of their numbers.

    An edit is first prepared, which raises if it is impossible and changes nothing, and then made
    by `make`. The history holds differences, and an edit looks only at the examples to change
    and at those with the same values. So both grow with the edits, not with the number of
    examples. Each edit also marks the default examples that a command contradicts, or no longer
    does (`hitab_core.default_example`).

    Attributes:
        history: the edits, for undo and redo.
        next_number, next_command: numbers of the next example and of the next command.
        recorded: number of examples that commands have added, deleted ones included.
    """

    def __init__(self, examples: Iterable[Example] = ()) -> None:
        self._examples: list[Example] = []
        self._by_number: dict[int, Example] = {}
        self._there = defaultdict[Place, set[int]](set)
        self._leaving = Counter[Place]()  # how many contradict default examples there
        self._contradictory = set[Place]()  # where ordinary examples contradict each other
        self._as_tuple: tuple[Example, ...] | None = None
        self.recorded = 0
        self.next_number = self.next_command = 1
        self.history = History()
        self.make(self.replacement(examples))
        self.history = History()
        self.recorded = 0

    @property
    def examples(self) -> tuple[Example, ...]:
        """All current examples."""
        if self._as_tuple is None:
            self._as_tuple = tuple(self._examples)
        return self._as_tuple

    def __len__(self) -> int:
        return len(self._examples)

    # -- preparing --------------------------------------------------------------------------

    def addition(
        self, taught: Sequence[Example], settled: Sequence[Example] = (), *, stays: bool = False
    ) -> Edit:
        """Prepare to add the examples of a command; the first one gives the states.

        Args:
            taught: the examples of the command.
            settled: earlier examples, changed in the light of the command
                (`hitab_core.assistant.lateness`).
            stays: whether the agent continued with what it did, as it then does after an undo.
        """
        if not taught:
            return Edit()
        first = taught[0]
        words = f"{first.state} → {first.next_state}, {quantity(len(taught), 'example')}"
        edit = self.replacement([*settled, *taught], words)
        return edit if stays else replace(edit, left=first.state, entered=first.next_state)

    def prepared(self, record: Mapping[str, Any]) -> Edit | None:
        """Prepare the edit that a record of the journal describes; None if there is none.

        Raises:
            TrainingError: if it is not possible.
        """
        match record["do"]:
            case "command":
                taught, settled = (
                    [from_dict(Example, e) for e in record.get(key, ())]
                    for key in ("examples", "settled")
                )
                return self.addition(taught, settled, stays=record.get("stays", False))
            case "undo":
                return self.history.undo()
            case "redo":
                return self.history.redo()
            case "delete_examples":
                wanted = self._known(record["numbers"])
                return self.replacement((), f"deleted {these(wanted)}", wanted)
            case "add":
                state, to, number = record["state"], record["next_state"], self.next_number
                kind, values = ExampleKind(record["kind"]), values_of(record["features"])
                example = Example(state, values, to, kind, number, self.next_command)
                return self.replacement([example], f"answered {state} → {to}")
            case "relabel_examples":
                given = tuple(map(float, record.get("with", ())))
                goes_on = record.get("goes_on")
                return self._relabeling(record["numbers"], record["next_state"], given, goes_on)
        return None

    def _relabeling(
        self,
        numbers: Iterable[int],
        next_state: str,
        given: tuple[float, ...],
        goes_on: bool | None,
    ) -> Edit:
        """Prepare to change next states; a default example becomes an ordinary one.

        The default example of a changed command says the same of the new next state.

        Args:
            numbers: numbers of the examples.
            next_state: the new one.
            given: numbers of the next state's behavior.
            goes_on: whether the new behavior continues, as a one-shot one does not; None in a
                record of an earlier version, and then default examples stay as they are.
        """
        wanted = self._known(numbers)
        changed = [
            replace(
                e,
                next_state=next_state,
                kind=ExampleKind.CORRECTION if e.is_default else e.kind,
                numbers=given,
            )
            for e in map(self._by_number.__getitem__, wanted)
            if (e.next_state, e.numbers) != (next_state, given)
        ]
        words = f"changed {these(e.number for e in changed)} to {next_state}" if changed else ""
        moved, gone = [], []
        for e in changed:
            default = self._by_number.get(e.number + 1)
            if default is None or not default.is_default or default.command != e.command:
                continue
            if goes_on is None or default.number in wanted or default.state == next_state:
                continue
            if goes_on and e.state != next_state:
                moved.append(replace(default, state=next_state, next_state=next_state))
            else:
                gone.append(default.number)
        if moved:
            words += f"; default {these(e.number for e in moved)} with it"
        if gone:
            words += f"; deleted default {these(gone)}"
        return self.replacement([*moved, *changed], words, gone)

    def replacement(
        self, changed: Iterable[Example], words: str = "", deleted: Iterable[int] = ()
    ) -> Edit:
        """Prepare to add examples, which replace any with the same numbers.

        Args:
            changed: the examples.
            words: the effect, for people.
            deleted: numbers of examples to delete.
        """
        came = {e.number: e for e in changed if self._by_number.get(e.number) is not e}
        gone = {n: self._by_number[n] for n in (*deleted, *came) if n in self._by_number}
        leaving = Counter(e.place for e in came.values() if e.leaves)
        leaving.subtract(e.place for e in gone.values() if e.leaves)
        for place, more in leaving.items():
            there = self._leaving[place]
            if bool(there) != bool(there + more):
                others = (self._by_number[n] for n in self._there[place] if n not in gone)
                assumed = {e.number: e for e in others if e.is_default}
                gone |= assumed
                came |= assumed
        for number, e in came.items():
            came[number] = marked(e, self._leaving[e.place] + leaving[e.place] > 0)
        superseded = [
            n
            for n, e in came.items()
            if not e.is_learned and (n not in gone or gone[n].is_learned)
        ]
        if superseded:
            words += f"; overruled {these(superseded)}"
        before, after = (tuple(sorted(es.values(), key=NUMBER)) for es in (gone, came))
        return Edit(words or "nothing", before, after)

    # -- doing ------------------------------------------------------------------------------

    def after(self, edit: Edit) -> tuple[Example, ...]:
        """Return the examples as they would be after an edit."""
        examples = list(self._examples)
        edit.apply(examples)
        return tuple(examples)

    def make(self, edit: Edit) -> None:
        """Make a prepared edit; no other edit may come in between."""
        edit.apply(self._examples)
        self._as_tuple = None
        for example in edit.gone:
            del self._by_number[example.number]
            self._count(example, -1)
        for example in edit.came:
            self._by_number[example.number] = example
            self._count(example, 1)
        self.recorded += sum(e.number >= self.next_number for e in edit.came)
        self.next_number = max((self.next_number, *(e.number + 1 for e in edit.came)))
        self.next_command = max((self.next_command, *(e.command + 1 for e in edit.came)))
        self.history.add(edit)

    def _count(self, example: Example, by: int) -> None:
        place = example.place
        self._there[place] ^= {example.number}
        if example.leaves:
            self._leaving[place] += by
        there = (self._by_number[number] for number in self._there[place])
        if len({e.next_state for e in there if not e.is_default}) > 1:
            self._contradictory.add(place)
        else:
            self._contradictory.discard(place)

    def contradictory(self) -> list[Example]:
        """Return examples that contradict each other, with all that their commands recorded."""
        numbers = {number for place in self._contradictory for number in self._there[place]}
        commands = {self._by_number[number].command for number in numbers} - {0}
        if not numbers:
            return []
        return [e for e in self._examples if e.command in commands or e.number in numbers]

    def commands_of(self, numbers: Iterable[int]) -> dict[int, int]:
        """Return the commands that examples were recorded by, each with one of these examples.

        Raises:
            TrainingError: if one of the numbers is unknown.
        """
        wanted = (self._by_number[number] for number in sorted(self._known(numbers), reverse=True))
        return {e.command: e.number for e in wanted}

    def _known(self, numbers: Iterable[int]) -> frozenset[int]:
        wanted = frozenset(numbers)
        if not wanted:
            raise TrainingError(f"no example numbers given {has(self._by_number)}")
        for number in sorted(wanted - self._by_number.keys()):
            raise TrainingError(f"no example number {number} {has(self._by_number)}")
        return wanted


def these(numbers: Iterable[int]) -> str:
    """Name examples by their numbers, unless they are many."""
    return numbered("example", numbers, NUMBERS_MAX)


def states_in(examples: Iterable[Example]) -> list[str]:
    """Return the states in examples, in order of appearance, without Start."""
    both = (label for e in examples for label in (e.state, e.next_state))
    return [label for label in dict.fromkeys(both) if label != START]
