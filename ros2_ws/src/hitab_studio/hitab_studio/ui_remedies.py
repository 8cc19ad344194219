"""Where on the page a person does what an error proposes."""

from __future__ import annotations

from typing import Any

from hitab_core import Do, HitabError, Remedy
from hitab_ros.conversions import remedies_of

BUTTONS = {
    Do.TRAIN: "Train… in Teach",
    Do.TRAIN_FURTHER: "Train further… in Library",
    Do.RESUME: "Back to training (T)",
    Do.DEMONSTRATE: "the buttons below the field",
    Do.CORRECT: "Take over (T), and its button below the field",
    Do.CHOOSE_FEATURES: "Features… in Teach",
    Do.RELABEL: "Relabel in Examples",
    Do.QUESTIONS: "Teach",
    Do.SAVE: "Save… in Teach",
    Do.DISCARD: "Discard… in Teach",
    Do.IDLE: "Go idle in Teach",
    Do.RESTORE: "the versions in Library",
    Do.SEND: "Distribute… in Library",
    Do.NEXT_GENERATION: "Generations… in Teach",
    Do.GO: "Release…",
    Do.ARM: "Re-arm",
    Do.DOWN: "Stop in Swarm",
}
"""The button, key or tab; without one, a remedy is put in plain words."""


def in_studio(remedy: Remedy) -> str:
    """Return a remedy with its place on the page."""
    place = BUTTONS.get(remedy.code)
    return f"{remedy}: {place}" if place else str(remedy)


def told(error: HitabError) -> str:
    """Return an error with its remedy on the page."""
    return "; ".join((error.problem, *map(in_studio, error.remedies)))


def answered(answer: Any) -> str:
    """Return a service's answer with the next step on the page."""
    return "; ".join((answer.message, *map(in_studio, remedies_of(answer.remedies))))
