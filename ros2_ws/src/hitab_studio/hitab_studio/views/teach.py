"""What was just recorded, and what the agent perceives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from hitab_client import SwarmError
from hitab_core import FLAGS, Example, FeatureKind
from hitab_studio import reasons
from hitab_studio.learned import superseding
from hitab_studio.reactions import EARLIER_SECONDS
from hitab_studio.session import Session
from hitab_studio.views.questions import questions, when_unsure

SHOWN = 6
"""Edits of the history that are shown on either side of now."""


@dataclass(frozen=True)
class Reading:
    """A feature with its value now and a little earlier."""

    automaton: str
    feature: str
    value: float
    unit: str
    description: str
    history: Sequence[float]
    boolean: bool


def context(session: Session) -> dict[str, Any]:
    """Return what the tab shows."""
    watched = session.watched
    training = watched.training
    examples = training.examples if training is not None else ()
    last = max((e.command for e in examples), default=0)
    return {
        "recorded": [e for e in examples if e.command == last] if last else [],
        "commands": len({e.command for e in examples}),
        "defaults": sum(e.is_default for e in examples),
        "readings": readings(session),
        "values_of": lambda example: _values(session, example),
        "trained": sorted(session.watched.vocabulary.trained),
        "last_edits": [(text, False) for text in watched.history.done[-SHOWN:]]
        + [(text, True) for text in watched.history.undone[:SHOWN]],
        "undo_off": reasons.undoing(session),
        "redo_off": reasons.redoing(session),
        "earlier_off": reasons.retiming(session),
        "earlier_seconds": EARLIER_SECONDS,
        "superseded": superseding(examples),
        "reaction": _reaction(session),
        "cost": watched.cost,
        "questions": questions(session),
        "when_unsure": when_unsure(session),
    }


def _reaction(session: Session) -> str:
    """Say for when the person's commands count."""
    try:
        seconds = session.shared.reactions.of(session.demonstrator)
    except SwarmError as error:
        return str(error)
    if seconds:
        return f"Your commands count {seconds:g} s earlier."
    return "Your commands count when you press the key."


def _values(session: Session, example: Example) -> list[tuple[str, float, str]]:
    training = session.watched.training
    if training is None:
        return []
    return list(zip(training.features, example.features, training.units, strict=True))


def readings(session: Session) -> list[Reading]:
    """Return what the agent perceives, level by level."""
    found = []
    vocabulary = session.watched.vocabulary
    for (automaton, feature), values in list(session.watched.readings.items()):
        history = list(values)
        if not history:
            continue
        name = feature.partition("(")[0]
        unit = vocabulary.units.get(name, "")
        about = vocabulary.feature_descriptions.get(name, "")
        boolean = name in FLAGS or vocabulary.kinds.get(name) == FeatureKind.BOOLEAN
        found.append(Reading(automaton, feature, history[-1], unit, about, history, boolean))
    return found
