"""What a simulated person does between trials: looks through what was recorded, answers questions.

The studio shows the situation of each example, lets a person have its command be due earlier or
later, and delete it; and the agent asks about what it was shown. A person judges a situation as
any other: by the intention, with edges that waver, and overlooks some.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from random import Random

from habits import Diary, Habits, looked_at
from intentions import OFF, Plan, Seen
from pupils import Pupil

from hitab_core import START, HitabError
from hitab_core.assistant import Question
from hitab_core.assistant.question import QuestionKind
from hitab_core.example import Example, ExampleKind

LONGEST = 1.5
"""Nobody looks for the right moment longer ago than this, s."""

LATER = 2
"""How many cycles later than recorded a person looks for it at first."""

ANSWERS = 3
"""The most questions that a person answers at a time."""


def as_seen(plan: Plan, values: Sequence[float]) -> Seen:
    """Return values of a plan's features as people see them: directions from -pi to pi."""
    seen = dict(zip(plan.features, values, strict=True))
    return {f: math.remainder(v, math.tau) if f == OFF else v for f, v in seen.items()}


class SecondThoughts:
    """Looks through examples, and answers questions, in one training.

    Args:
        pupil: has recorded them.
        plan: what is intended.
        habits, random, diary: of the person.
    """

    def __init__(
        self,
        pupil: Pupil,
        plan: Plan,
        habits: Habits,
        random: Random,
        diary: Diary,
    ) -> None:
        self.pupil, self.plan, self.habits = pupil, plan, habits
        self.random, self.diary = random, diary

    def judge(self) -> Callable[[str, Seen], str]:
        """Return what the person would do next, given a state and what is seen, as of now."""
        w = self.habits.waver
        edges = {
            name: edge * self.random.uniform(1.0 - w, 1.0 + w)
            for name, edge in self.plan.edges.items()
        }
        errors = self.habits.errors(self.random)
        return lambda state, seen: self.plan.rule(state, looked_at(seen, errors), edges)

    # -- what was recorded ------------------------------------------------------------------

    def review(self, numbers: Iterable[int]) -> list[Example]:
        """Look through commands that were just given; return those that were deleted.

        A command is moved to the first moment at which it was right. If it was never right, it is
        deleted, unless it only comes a little early or late. A default example is deleted where
        the person would not stay.
        """
        deleted = []
        for number in numbers:
            example = self._example(number)
            if example is None or self.random.random() < self.habits.overlooks:
                continue
            if not self._place(example) and not self._may_be_meant(example):
                self._delete(
                    [e.number for e in self.pupil.examples() if e.command == example.command]
                )
                self.diary.counts["deleted"] += 1
                deleted.append(example)
                continue
            self._check_default(example.command)
        return deleted

    def _delete(self, numbers: Sequence[int]) -> None:
        """Delete examples, out of a test if nothing would be left to begin it with."""
        try:
            self.pupil.delete(numbers)
        except HitabError:
            self.pupil.take_over()
            self.pupil.delete(numbers)

    def _check_default(self, command: int) -> None:
        """Delete the default example of a command if the person would not stay there."""
        wish = self.judge()
        for e in self.pupil.examples():
            stays = e.command == command and e.kind is ExampleKind.DEFAULT
            if stays and wish(e.state, self._seen(e)) != e.next_state:
                self.pupil.delete([e.number])
                self.diary.counts["defaults deleted"] += 1

    def _place(self, example: Example) -> bool:
        """Have a command be due when it was right first; return whether it ever was."""
        wish, cycle = self.judge(), self.pupil.cycle_seconds

        def is_right(at: Example | None) -> bool:
            return at is not None and wish(at.state, self._seen(at)) == at.next_state

        ago = example.ago
        found: Example | None = example
        if not is_right(found):
            later = [ago - i * cycle for i in range(1, LATER + 1) if ago - i * cycle > -cycle / 2]
            count = round((LONGEST - ago) / cycle)
            for time in (*later, ago, *(ago + i * cycle for i in range(1, count + 1))):
                found = self._moved(example, max(0.0, time))
                if is_right(found):
                    ago = max(0.0, time)
                    break
            else:
                self._moved(example, ago)
                return False
        while ago < LONGEST and found is not None and found.next_state != found.state:
            earlier = self._moved(example, ago + cycle)
            if not is_right(earlier):
                self._moved(example, ago)
                break
            found, ago = earlier, ago + cycle
        return True

    def _may_be_meant(self, example: Example) -> bool:
        """Return whether a person who watches would let an example pass."""
        return example.next_state in self.plan.fitting(example.state, self._seen(example))

    def _moved(self, example: Example, ago: float) -> Example | None:
        """Have a command be due some time ago; return its example, None if that is not kept."""
        try:
            self.pupil.retime([example.number], ago)
        except HitabError:
            return None
        self.diary.counts["moved"] += 1
        return self._example(example.number)

    def _example(self, number: int) -> Example | None:
        return next((e for e in self.pupil.examples() if e.number == number), None)

    def _seen(self, example: Example) -> Seen:
        return as_seen(self.plan, example.features)

    # -- questions --------------------------------------------------------------------------

    def answer(self, allowance: int, most: int = ANSWERS) -> list[Example]:
        """Answer what the agent asks, as long as there is something, and budget.

        Args:
            allowance: the most examples that all trainings may hold.
            most: questions that the person answers now.

        Returns:
            The examples that answers have deleted, default ones left out.
        """
        before, answered = self.pupil.examples(), set()
        for _ in range(most):
            examples = self.pupil.examples()
            if self.pupil.held >= allowance or not any(e.state == START for e in examples):
                break
            questions = self.pupil.questions()
            if not questions:
                break
            asked = (questions[0].state, questions[0].situation)
            self._answer(questions[0], again=asked in answered)
            answered.add(asked)
        return self._gone(before)

    def settle(self) -> list[Example]:
        """Say which of two commands in the same situation holds, as soon as the agent asks.

        Returns:
            The examples that this has deleted, default ones left out.
        """
        before = self.pupil.examples()
        for _ in range(ANSWERS):
            if not self.pupil.contradictions():
                break
            self._answer(self.pupil.questions()[0])
        return self._gone(before)

    def _gone(self, before: Sequence[Example]) -> list[Example]:
        kept = {example.number for example in self.pupil.examples()}
        return [e for e in before if e.number not in kept and not e.is_default]

    def _answer(self, question: Question, *, again: bool = False) -> None:
        """Answer by the intention; dismiss what it does not decide, or has decided before."""
        choice = ""
        if question.kind in (QuestionKind.LATE, QuestionKind.CORRECTION):
            choice = self._when(question)
        elif question.situation and not any(map(math.isnan, question.situation)) and not again:
            seen = as_seen(self.plan, question.situation)
            wished = self.judge()(question.state, seen)
            choice = wished if wished in {c.name for c in question.choices} else ""
        self.pupil.answer(question.number, choice)
        self.diary.counts["answers" if choice else "dismissed"] += 1
        self.diary.counts[f"{question.kind} {'answered' if choice else 'dismissed'}"] += 1

    def _when(self, question: Question) -> str:
        """Return the first of the moments at which a command was right; "" if it never was."""
        wish = self.judge()
        example = self._example(question.examples[0])
        right = [
            choice
            for choice in question.choices
            if example is not None
            and choice.situation  # a message has only what would be done
            and wish(choice.state, as_seen(self.plan, choice.situation)) == example.next_state
        ]
        earliest = max(right, key=lambda choice: float(choice.record["ago"]), default=None)
        return "" if earliest is None else earliest.name
