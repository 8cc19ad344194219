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

from hitab_core.errors import HitabError
from hitab_core.example_codec import example_of
from hitab_core.training.example_log import ExampleLog
from hitab_core.training.training_journal import RESUMED, TrainingJournal
from hitab_core.training.undo import Edit

PAUSE_SECONDS = 300.0
"""A person who did nothing for longer was away; that time is not counted."""


@dataclass(frozen=True, slots=True)
class TrainingCost:
    """Cost of one training.

    Attributes:
        automaton: its name.
        began: when, in ISO 8601.
        wall_seconds: that the person took; pauses of more than `PAUSE_SECONDS` count as none, and
            neither does the time before the training was resumed in another process.
        simulated_seconds: of the world, between the steps of the person.
        commands: that were given.
        examples: that there were in the end, as a list of them shows; superseded ones included.
        wasted: examples that were recorded and not learned from: deleted, undone or superseded.
        undos: of anything.
        structures: sets of features that were tried.
        proposals: of the agent that were accepted.
        finished: whether it was saved.
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
    """Return what the trainings on disk cost, oldest first.

    Those of which nothing is known, in which nothing was done, or whose records are damaged,
    are left out.
    """
    # Only the training that this process has under way goes on.
    costs = (
        _cost(records, time.time() if training == journal.under_way else None)
        for training, records in journal.kept()
        if has_steps(records)
    )
    return sorted(filter(None, costs), key=lambda cost: cost.began)


def unsaved_cost(journal: TrainingJournal) -> TrainingCost | None:
    """Return what the training that the next start resumes has cost so far.

    None: there is none, it is saved already, or it is damaged.
    """
    cost = _cost(journal.to_resume())
    return None if cost is None or cost.finished else cost


def _cost(records: Sequence[Mapping[str, Any]], now: float | None = None) -> TrainingCost | None:
    """Return what a training cost; None if nothing is known.

    Args:
        records: of the training.
        now: the time, if the training goes on.
    """
    with suppress(HitabError, KeyError, TypeError, ValueError):
        return training_cost(records, now)
    return None


def training_cost(records: Iterable[Mapping[str, Any]], now: float | None = None) -> TrainingCost:
    """Return what a training cost.

    Args:
        records: of its journal, all of them.
        now: the time; None once the training is saved, given up or interrupted.

    Raises:
        TrainingError, KeyError, TypeError, ValueError: if they are no journal.
    """
    begin, *lines = records
    rest = [record for record in lines if record["do"] != RESUMED]
    log = ExampleLog(map(example_of, begin["examples"]))
    told: list[str] = []
    for record in rest:
        told.append(str(record["do"]))
        # What was retimed, or learned from other features, is as many examples as before.
        edit = Edit() if told[-1] in ("retime", "features") else log.prepared(record)
        if edit is not None:
            log.make(edit)
    walls = [[float(begin["at"])]]
    for record in lines:
        if record["do"] == RESUMED:
            walls.append([])
        walls[-1].append(float(record["at"]))
    simulated = [float(record["time"]) for record in rest if "time" in record]
    finished = bool(rest) and rest[-1]["do"] == "save"
    if not finished and now is not None:
        walls[-1].append(min(now, walls[-1][-1] + PAUSE_SECONDS))
    learned = sum(example.is_learned for example in log.examples)
    name = rest[-1]["automaton"] if finished else begin["curriculum"]["automaton"]
    return TrainingCost(
        str(name),
        datetime.fromtimestamp(walls[0][0], UTC).isoformat(timespec="seconds"),
        sum(_passed(times, PAUSE_SECONDS) for times in walls),
        _passed(simulated, PAUSE_SECONDS),
        told.count("command"),
        len(log),
        max(0, len(begin["examples"]) + log.recorded - learned),
        told.count("undo"),
        1 + told.count("features"),
        sum(1 for record in rest if record.get("proposed")),
        finished,
    )


def has_steps(records: Iterable[Mapping[str, Any]]) -> bool:
    """Return whether a person has done anything in a training since it began."""
    return any(record.get("do") not in ("begin", RESUMED) for record in records)


def _passed(times: list[float], longest: float) -> float:
    """Return the time that passed, without jumps back and without what took too long."""
    steps = (after - before for before, after in pairwise(times))
    return sum(step for step in steps if 0.0 < step <= longest)
