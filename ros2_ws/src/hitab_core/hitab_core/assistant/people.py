"""Lateness of each person's commands, as texts that an agent's journal keeps.

Nothing but the first commands of the next training depends on it, so a text that cannot be used is
left out.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress

import numpy as np

from hitab_core.assistant.lateness import MODELS, Lateness


def people_from(texts: Mapping[str, str]) -> dict[str, Lateness]:
    """Return how late each person's commands come; people without a usable text are left out."""
    people: dict[str, Lateness] = {}
    for who, text in texts.items():
        with suppress(ValueError, TypeError):
            odds = np.array(json.loads(text), np.float64)
            if odds.shape == (MODELS,) and (odds >= 0.0).all() and odds.any():
                people[who] = Lateness(odds / odds.sum())
    return people


def texts_of(people: Mapping[str, Lateness]) -> dict[str, str]:
    """Return a text for how late each person's commands come."""
    return {who: json.dumps(known.odds.round(6).tolist()) for who, known in people.items()}
