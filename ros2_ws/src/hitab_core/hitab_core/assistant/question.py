"""A question of an agent to its demonstrator, and its answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from hitab_core.advice.evidence import answer_kind
from hitab_core.codec import plain_values
from hitab_core.texts.errors import TrainingError
from hitab_core.texts.vocabulary import has


class QuestionKind(StrEnum):
    """Kind of a question."""

    CONTRADICTION = "contradiction"
    UNSHOWN = "unshown"


@dataclass(frozen=True)
class Choice:
    """One answer to a question.

    Attributes:
        name: text of the answer.
        effect: effect of the answer, in words.
        record: this step of the training, as in the journal; None if the answer changes
            nothing and the question is not asked again.
    """

    name: str
    effect: str
    record: Mapping[str, Any] | None


@dataclass(frozen=True)
class Question:
    """A question to the demonstrator.

    Attributes:
        number: unique within the training.
        kind: kind of the question.
        text: the question.
        state: label of the state whose decision it is about.
        examples: numbers of the examples in question.
        choices: possible answers; the first one is proposed.
        situation: values of the automaton's features, NaN for any; empty for no situation.
        key: identity of the question, if it is found again.
    """

    number: int
    kind: QuestionKind
    text: str
    state: str
    examples: tuple[int, ...]
    choices: tuple[Choice, ...]
    situation: tuple[float, ...] = ()
    key: tuple[Any, ...] = field(default=(), repr=False)

    @property
    def words(self) -> tuple[str, ...]:
        """The key as plain data, for the journal."""
        return tuple(map(str, self.key))


def added(
    state: str, situation: Sequence[float], next_state: str, *, bisects: bool = False
) -> Mapping[str, Any]:
    """Return the step of a training that adds an example, as the journal records it.

    For the arguments see `answer_kind`.
    """
    kind = answer_kind(state, next_state, bisects=bisects).value
    return {
        "do": "add",
        "state": state,
        "features": plain_values(situation),
        "next_state": next_state,
        "kind": kind,
    }


def choice_of(question: Question, name: str) -> Choice:
    """Return a choice by its name; empty for the proposed one.

    Raises:
        TrainingError: if there is none of this name.
    """
    if not name:
        return question.choices[0]
    for choice in question.choices:
        if choice.name == name:
            return choice
    there = [choice.name for choice in question.choices]
    raise TrainingError(f'question {question.number} has no choice "{name}" {has(there, name)}')
