"""A question of an agent to its demonstrator, and its answers."""

from __future__ import annotations

import math
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
    LATE = "late"
    CORRECTION = "correction"
    FEATURE = "feature"


ASKED = tuple(kind.value for kind in QuestionKind if kind is not QuestionKind.CONTRADICTION)
"""The kinds of questions that can be left out."""


@dataclass(frozen=True)
class Choice:
    """One answer to a question.

    Attributes:
        name: text of the answer.
        effect: effect of the answer, in words.
        record: this step of the training, as in the journal.
        state, situation: where the command is due by this answer, and the features' values there;
            empty if all answers are about the situation of the question.
        changes: the part of the situations met that would be decided otherwise than without an
            answer.
        cycles, states: what it would do over the percepts from the situation on: from
            ``cycles[i]`` on it would be in ``states[i]``.
    """

    name: str
    effect: str
    record: Mapping[str, Any]
    state: str = ""
    situation: tuple[float, ...] = ()
    changes: float = 0.0
    cycles: tuple[int, ...] = ()
    states: tuple[str, ...] = ()


@dataclass(frozen=True)
class Question:
    """A question to the demonstrator.

    Attributes:
        number: unique within the training.
        kind: kind of the question.
        text: the question.
        state: label of the state whose decision it is about.
        choices: possible answers, the most probable first.
        examples: numbers of the examples in question.
        situation: values of the automaton's features, NaN for any; empty for no situation.
        proposed: name of the answer for which the examples speak; empty if they leave it open.
        cycle: the world's cycle at which the situation was met; 0 if unknown.
        matters: the part of the situations met that the two most probable answers decide
            otherwise; NaN if unknown.
        key: identity of the question, if it is found again.
    """

    number: int
    kind: QuestionKind
    text: str
    state: str
    choices: tuple[Choice, ...]
    examples: tuple[int, ...] = ()
    situation: tuple[float, ...] = ()
    proposed: str = ""
    cycle: int = 0
    matters: float = math.nan
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
        TrainingError: if there is none of this name, or none is proposed.
    """
    there = [choice.name for choice in question.choices]
    if not (name or question.proposed):
        raise TrainingError(
            f"no answer to question {question.number} is proposed, since the examples do not "
            f"decide it; choose one of: {', '.join(there)}"
        )
    for choice in question.choices:
        if choice.name == (name or question.proposed):
            return choice
    raise TrainingError(f'question {question.number} has no choice "{name}" {has(there, name)}')
