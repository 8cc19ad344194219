"""Cost of a training for the demonstrator, from its journal.

Source: the paper, table 1, counts the examples and the minutes of each behavior.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import pairwise
from typing import Any

from hitab_core.codec import from_dict
from hitab_core.example import Example
from hitab_core.texts.errors import HitabError
from hitab_core.training.example_log import ExampleLog
from hitab_core.training.training_journal import (
    DISCARDED,
    RESUMED,
    SAVED,
    TrainingJournal,
)
from hitab_core.training.undo import Edit

PAUSE_SECONDS = 300.0
"""A person who did nothing for longer was away; that time is not counted."""


@dataclass(frozen=True, slots=True)
class TrainingCost:
    """Cost of one training.

    Attributes:
        automaton: name of the automaton.
        began: time of the beginning, ISO 8601.
        wall_seconds: time that the person took, without pauses longer than `PAUSE_SECONDS` and
            without the time until the training was resumed in another process.
        simulated_seconds: simulated time between the steps of the person.
        commands: number of commands.
        examples: number of examples in the end, superseded ones included.
        wasted: number of recorded examples that were deleted, undone or superseded.
        undos: number of undos.
        structures: number of sets of features that were tried.
        proposals: number of the agent's proposals that were accepted.
        finished: whether the training was saved.
    """

    automaton: str
    began: str
    wall_seconds: float
    simulated_seconds: float
    commands: int
    examples: int
    wasted: int
    undos: int
    structures: int
    proposals: int
    finished: bool


def training_costs(journal: TrainingJournal) -> list[TrainingCost]:
    """Return the costs of the trainings on disk, oldest first.

    Trainings without records or steps, and those with damaged records, are left out.
    """
    # Only the training that this process has under way goes on.
    costs = (
        _cost(records, time.time() if training == journal.under_way else None)
        for training, records in journal.kept()
        if has_steps(records)
    )
    return sorted(filter(None, costs), key=lambda cost: cost.began)


def unsaved_cost(journal: TrainingJournal) -> TrainingCost | None:
    """Return the cost so far of the training that the next start resumes.

    None if there is none, or if it is saved already or damaged.
    """
    cost = _cost(journal.to_resume())
    return None if cost is None or cost.finished else cost


def _cost(records: Sequence[Mapping[str, Any]], now: float | None = None) -> TrainingCost | None:
    """Return the cost of a training; None if its records are damaged.

    Args:
        records: records of the training.
        now: the time, if the training goes on.
    """
    with suppress(HitabError, KeyError, TypeError, ValueError):
        return training_cost(records, now)
    return None


def training_cost(records: Iterable[Mapping[str, Any]], now: float | None = None) -> TrainingCost:
    """Return the cost of a training.

    Args:
        records: all records of its journal.
        now: the time; None once the training is saved, given up or interrupted.

    Raises:
        TrainingError, KeyError, TypeError, ValueError: if they are no journal.
    """
    begin, *lines = records
    rest = [record for record in lines if record["do"] != RESUMED]
    log = ExampleLog(from_dict(Example, e) for e in begin["examples"])
    steps: list[str] = []
    for record in rest:
        steps.append(str(record["do"]))
        # Retiming and other features do not change the number of examples.
        edit = (
            Edit() if steps[-1] in ("retime_examples", "choose_features") else log.prepared(record)
        )
        if edit is not None:
            log.make(edit)
    walls = [[float(begin["at"])]]
    for record in lines:
        if record["do"] == RESUMED:
            walls.append([])
        walls[-1].append(float(record["at"]))
    simulated = [float(record["time"]) for record in rest if "time" in record]
    finished = bool(rest) and rest[-1]["do"] == SAVED
    if not finished and now is not None:
        walls[-1].append(min(now, walls[-1][-1] + PAUSE_SECONDS))
    learned = sum(example.is_learned for example in log.examples)
    name = rest[-1]["automaton"] if finished else begin["curriculum"]["name"]
    return TrainingCost(
        str(name),
        datetime.fromtimestamp(walls[0][0], UTC).isoformat(timespec="seconds"),
        sum(_passed(times, PAUSE_SECONDS) for times in walls),
        _passed(simulated, PAUSE_SECONDS),
        steps.count("command"),
        len(log),
        max(0, len(begin["examples"]) + log.recorded - learned),
        steps.count("undo"),
        1 + steps.count("choose_features"),
        sum(1 for record in rest if record.get("proposed")),
        finished,
    )


def has_steps(records: Iterable[Mapping[str, Any]]) -> bool:
    """Return whether a person has done anything in a training since it began."""
    return any(
        record.get("do") not in ("begin_training", DISCARDED, RESUMED) for record in records
    )


def _passed(times: list[float], longest: float) -> float:
    """Return the time that passed, without jumps back and without steps that took too long."""
    steps = (after - before for before, after in pairwise(times))
    return sum(step for step in steps if 0.0 < step <= longest)
