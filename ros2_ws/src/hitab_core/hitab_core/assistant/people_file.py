"""The file in which an agent keeps how late the commands of each person come.

Nothing but the first commands of the next training depends on it, so a file that cannot be used is
ignored, and one that cannot be written is left out.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np

from hitab_core.assistant.lateness import MEDIANS, SPREADS, Lateness
from hitab_core.library.durable_files import write_durably

PEOPLE_FILE = "lateness.json"
PEOPLE_FORMAT = 1


def read_people(folder: Path | None) -> dict[str, Lateness]:
    """Return how late each person's commands come; people without a usable entry are left out."""
    people: dict[str, Lateness] = {}
    if folder is None:
        return people
    with suppress(OSError, ValueError, TypeError, KeyError, AttributeError):
        kept = json.loads((folder / PEOPLE_FILE).read_text("utf-8"))
        for who, rows in kept["people"].items() if kept["version"] == PEOPLE_FORMAT else ():
            odds = np.array(rows, np.float64)
            if odds.shape == (len(MEDIANS), len(SPREADS)) and (odds >= 0.0).all() and odds.any():
                people[who] = Lateness(odds / odds.sum())
    return people


def write_people(folder: Path | None, people: Mapping[str, Lateness]) -> None:
    """Keep how late each person's commands come."""
    if folder is None or not people:
        return
    rows = {who: lateness.odds.round(6).tolist() for who, lateness in people.items()}
    text = json.dumps({"version": PEOPLE_FORMAT, "people": rows}) + "\n"
    with suppress(OSError):
        write_durably(folder / PEOPLE_FILE, text.encode())
