"""The generations of a behavior, and how far the next one is."""

from __future__ import annotations

from typing import Any

from hitab_client import SwarmError
from hitab_client.bootstrapping import Generations
from hitab_studio import unavailable
from hitab_studio.generations import known_generations
from hitab_studio.page_state import PageState
from hitab_studio.ui_remedies import told


def context(session: PageState) -> dict[str, Any]:
    """Return what the dialog shows."""
    agent, behavior = session.dialog["agent"], session.dialog["behavior"]
    training, known, problem = session.training, Generations(), ""
    try:
        known = known_generations(session.shared.store.known.target, agent, behavior)
    except SwarmError as error:
        problem = told(error)
    off = problem or session.shared.generations.why_busy
    next_off = unavailable.testing(session)
    if training is None or training.name != behavior:
        next_off = (
            f"{behavior} is not being trained: train it further, or go back to a generation."
        )
    return {
        "generations": known.all,
        "best": known.best(),
        "problem": problem,
        "mates": [a for a in session.agents if a != agent],
        "back_off": off or unavailable.agent(session),
        "next_off": off or next_off,
    }
