"""The generations of a behavior, and how far the next one is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hitab_client import SwarmError
from hitab_client.bootstrapping import Generation, Generations
from hitab_studio import unavailable
from hitab_studio.actions.bootstrapping import AS_IT_IS, SNAPSHOT
from hitab_studio.generations import known_generations
from hitab_studio.remedy_words import told
from hitab_studio.session import Session


@dataclass(frozen=True)
class Row:
    """A generation, in words.

    Attributes:
        parent: number of the one that it continues; 0: none.
        score: the mean length of an episode, or why there is none.
        current: whether the training goes on from it.
        best: whether it has the best score of those that can be compared.
    """

    number: int
    parent: int
    version: str
    score: str
    played: str
    examples: int
    when: str
    who: str
    note: str
    current: bool
    best: bool


def context(session: Session) -> dict[str, Any]:
    """Return what the dialog shows."""
    agent, behavior = session.dialog["agent"], session.dialog["behavior"]
    store, training = session.shared.store, session.watched.training
    problem = ""
    known: Generations | None = None
    try:
        known = known_generations(store.known.target, agent, behavior)
    except SwarmError as error:
        problem = told(error)
    trains = training is not None and training.name == behavior
    busy = session.shared.generations.why_busy
    return {
        "rows": _rows(known) if known is not None else [],
        "problem": problem,
        "making": session.shared.generations.making,
        "mates": [a for a in session.agents if a != agent],
        "situations": [AS_IT_IS, *(f"{SNAPSHOT}{name}" for name in store.snapshots)],
        "has_world": store.known.world is not None,
        "back_off": problem or busy or unavailable.agent(session),
        "next_off": problem or busy or _next_off(session, behavior, trains=trains),
    }


def _next_off(session: Session, behavior: str, *, trains: bool) -> str:
    if not trains:
        return f"{behavior} is not being trained: train it further, or go back to a generation."
    return unavailable.saving(session)


def _rows(known: Generations) -> list[Row]:
    best = known.best()
    return [
        Row(
            generation.number,
            generation.parent,
            ", ".join(map(str, (generation.version, *generation.restored))),
            *_score(generation),
            generation.examples,
            generation.at.replace("T", " ").removesuffix("Z")[:16],
            generation.by,
            generation.note,
            generation.number == known.current,
            best is not None and generation.number == best.number,
        )
        for generation in known.all
    ]


def _score(generation: Generation) -> tuple[str, str]:
    score = generation.score
    if score is None:
        return "none", generation.unscored
    return f"{score.figures['seconds']} s", f"{score.episodes} episodes, seed {score.seed}"
