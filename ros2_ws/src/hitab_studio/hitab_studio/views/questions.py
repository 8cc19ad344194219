"""What an agent asks about its examples, each question with its answers."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hitab_msgs.msg import Question

from hitab_studio.session import Session
from hitab_studio.views.numbers import measured

WHEN_UNSURE = {
    "go_on": ("go on", "it decides all the same"),
    "halt": ("halt", "it does nothing until it is sure"),
    "hand_back": ("hand back", "you decide, as in training"),
}

TITLES = {
    Question.CONTRADICTION: "Two commands disagree",
    Question.MISTAKE: "Was an example a mistake?",
    Question.SPARSE: "Too few examples here",
    Question.AMBIGUITY: "Two explanations fit",
}


@dataclass(frozen=True)
class ShownQuestion:
    """A question.

    Attributes:
        title: what kind of question it is.
        answers: each with its effect, and whether it is proposed; the proposed one first.
        situation: names of the features where it is to be decided, and their values for people.
    """

    number: int
    title: str
    text: str
    answers: tuple[tuple[str, str, bool], ...]
    situation: tuple[tuple[str, str], ...]


def questions(session: Session) -> list[ShownQuestion]:
    """Return the open questions of the agent."""
    training = session.watched.training
    return [
        ShownQuestion(
            question.number,
            TITLES.get(question.kind, "A question"),
            question.text,
            _answers(question),
            tuple(
                (read.feature, measured(session, read.feature, read.value))
                for read in question.situation
                if not math.isnan(read.value)
            ),
        )
        for question in (training.questions if training is not None else ())
    ]


def _answers(question: Question) -> tuple[tuple[str, str, bool], ...]:
    """Return the answers to choose from, the proposed one first."""
    return tuple((choice.name, choice.effect, i == 0) for i, choice in enumerate(question.choices))


def when_unsure(session: Session) -> str:
    """Return what the agent does when it is unsure, for people."""
    status = session.status
    return WHEN_UNSURE.get(status.when_unsure if status is not None else "", ("go on", ""))[0]
