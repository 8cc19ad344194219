"""The generations of a behavior, and how far the next one is."""

from __future__ import annotations

from typing import Any

from hitab_client import SwarmError
from hitab_client.bootstrapping import Generations
from hitab_studio import unavailable
from hitab_studio.actions.bootstrapping import AS_IT_IS, SNAPSHOT
from hitab_studio.generations import known_generations
from hitab_studio.page_state import PageState
from hitab_studio.ui_remedies import told


def context(session: PageState) -> dict[str, Any]:
    """Return what the dialog shows."""
    agent, behavior = session.dialog["agent"], session.dialog["behavior"]
    store, training = session.shared.store, session.training
    problem = ""
    known: Generations | None = None
    try:
        known = known_generations(store.known.target, agent, behavior)
    except SwarmError as error:
        problem = told(error)
    trains = training is not None and training.name == behavior
    busy = session.shared.generations.why_busy
    generations = known.all if known is not None else ()
    best = known.best() if known is not None else None
    next_off = unavailable.testing(session)
    if not trains:
        next_off = (
            f"{behavior} is not being trained: train it further, or go back to a generation."
        )
    return {
        "generations": generations,
        "current": known.current if known is not None else 0,
        "best": best.number if best is not None else 0,
        "problem": problem,
        "mates": [a for a in session.agents if a != agent],
        "situations": [AS_IT_IS, *(f"{SNAPSHOT}{name}" for name in store.snapshots)],
        "back_off": problem or busy or unavailable.agent(session),
        "next_off": problem or busy or next_off,
    }
