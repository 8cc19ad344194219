"""The generations of a behavior, and how far the next one is."""

from __future__ import annotations

from typing import Any

from hitab_client import SwarmError
from hitab_client.bootstrapping import Generations
from hitab_studio import unavailable
from hitab_studio.generations import known_generations
from hitab_studio.page import Page
from hitab_studio.ui_remedies import told


def context(page: Page) -> dict[str, Any]:
    """Return what the dialog shows."""
    agent, behavior = page.dialog["agent"], page.dialog["behavior"]
    training, known, problem = page.training, Generations(), ""
    try:
        known = known_generations(page.studio.known.target, agent, behavior)
    except SwarmError as error:
        problem = told(error)
    off = problem or page.studio.generations.why_busy
    next_off = unavailable.testing(page)
    if training is None or training.name != behavior:
        next_off = (
            f"{behavior} is not being trained: train it further, or go back to a generation."
        )
    return {
        "generations": known.all,
        "best": known.best(),
        "problem": problem,
        "mates": [a for a in page.agents if a != agent],
        "back_off": off or page.agent_off,
        "next_off": off or next_off,
    }
