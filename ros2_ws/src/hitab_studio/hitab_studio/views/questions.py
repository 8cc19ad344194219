"""What an agent asks about its examples, each question with its answers."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hitab_studio.session import Session

WHEN_UNSURE = {
    "go_on": ("go on", "it decides all the same"),
    "halt": ("halt", "it does nothing until it is sure"),
    "hand_back": ("hand back", "you decide, as in training"),
}


@dataclass(frozen=True)
class Asked:
    """A question.

    Attributes:
        answers: each with its effect, and whether it is proposed.
        situation: names and values of the features where it is to be decided.
    """

    number: int
    kind: str
    text: str
    answers: tuple[tuple[str, str, bool], ...]
    situation: tuple[tuple[str, float], ...]


def questions(session: Session) -> list[Asked]:
    """Return the open questions of the agent."""
    return [
        Asked(
            question.number,
            question.kind,
            question.text,
            tuple(
                (choice, effect, i == question.proposed)
                for i, (choice, effect) in enumerate(
                    zip(question.choices, question.effects, strict=True)
                )
            ),
            tuple(
                (feature, value)
                for feature, value in zip(question.features, question.situation, strict=True)
                if not math.isnan(value)
            ),
        )
        for question in session.watched.questions
    ]


def when_unsure(session: Session) -> str:
    """Return what the agent does when it is unsure, for people."""
    status = session.status
    return WHEN_UNSURE.get(status.when_unsure if status is not None else "", ("go on", ""))[0]
