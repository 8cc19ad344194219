"""What was just recorded, and what the agent perceives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from hitab_core import Example
from hitab_studio.session import Session


@dataclass(frozen=True)
class Reading:
    """A feature with its value now and a little earlier."""

    automaton: str
    feature: str
    value: float
    unit: str
    history: Sequence[float]
    boolean: bool


def context(session: Session) -> dict[str, Any]:
    """Return what the tab shows."""
    training = session.watched.training
    examples = training.examples if training is not None else ()
    last = max((e.command for e in examples), default=0)
    return {
        "recorded": [e for e in examples if e.command == last] if last else [],
        "commands": len({e.command for e in examples}),
        "defaults": sum(e.is_default for e in examples),
        "readings": readings(session),
        "values_of": lambda example: _values(session, example),
        "trained": sorted(session.watched.vocabulary.trained),
    }


def _values(session: Session, example: Example) -> list[tuple[str, float, str]]:
    training = session.watched.training
    if training is None:
        return []
    return list(zip(training.features, example.features, training.units, strict=True))


def readings(session: Session) -> list[Reading]:
    """Return what the agent perceives, level by level."""
    found = []
    units = session.watched.vocabulary.units
    for (automaton, feature), values in list(session.watched.readings.items()):
        history = list(values)
        if not history:
            continue
        name = feature.partition("(")[0]
        known = [v for v in history if not math.isnan(v)]
        boolean = all(v in (0.0, 1.0) for v in known) and not units.get(name)
        unit = units.get(name, "")
        found.append(Reading(automaton, feature, history[-1], unit, history, boolean))
    return found
