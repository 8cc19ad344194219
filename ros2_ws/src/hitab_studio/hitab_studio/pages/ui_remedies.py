"""Remedies of errors, with the button or tab of the page that carries them out."""

from __future__ import annotations

from typing import Any

from hitab_core import Fix, HitabError, Remedy
from hitab_ros.messages.conversions import remedies_of

BUTTONS = {
    Fix.TRAIN: "Train… in Teach",
    Fix.TRAIN_FURTHER: "Train further… in Library",
    Fix.RESUME: "Back to training (T)",
    Fix.DEMONSTRATE: "the buttons below the field",
    Fix.CORRECT: "Take over (T), and its button below the field",
    Fix.CHOOSE_FEATURES: "Features… in Teach",
    Fix.RELABEL: "Relabel in Examples",
    Fix.QUESTIONS: "Teach",
    Fix.SAVE: "Save… in Teach",
    Fix.DISCARD: "Discard… in Teach",
    Fix.IDLE: "Go idle in Teach",
    Fix.RESTORE: "the versions in Library",
    Fix.SEND: "Distribute… in Library",
    Fix.GIVE: "Distribute… in Library",
    Fix.NEXT_GENERATION: "Generations… in Teach",
    Fix.GO: "Release…",
    Fix.ARM: "Re-arm",
    Fix.DOWN: "Stop in Swarm",
}
"""The button, key or tab of each remedy; others are shown in words only."""


def in_studio(remedy: Remedy) -> str:
    """Return a remedy with its place on the page."""
    place = BUTTONS.get(remedy.code)
    return f"{remedy}: {place}" if place else str(remedy)


def error_text(error: HitabError) -> str:
    """Return the text of an error, with the remedies on the page."""
    return "; ".join((error.problem, *map(in_studio, error.remedies)))


def answer_text(answer: Any) -> str:
    """Return the text of a service's answer, with the remedies on the page."""
    return "; ".join((answer.message, *map(in_studio, remedies_of(answer.remedies))))
