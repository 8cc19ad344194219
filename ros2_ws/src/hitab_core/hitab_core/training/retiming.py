"""Retiming: changes the time at which commands were due, and so their examples' situations."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from hitab_core.automaton import as_entered
from hitab_core.example import Example
from hitab_core.texts.errors import TrainingError
from hitab_core.training.example_log import these
from hitab_core.training.percept_history import STEP_SECONDS
from hitab_core.training.percepts import PerceptRecord, nearest
from hitab_core.training.trainer import Trainer
from hitab_core.training.undo import Edit


def retiming(trainer: Trainer, numbers: Iterable[int], ago: float) -> Edit:
    """Prepare to change the time at which commands were due.

    Args:
        trainer: the trainer.
        numbers: numbers of examples; each stands for its command.
        ago: time from when it was due to the command, s.

    Raises:
        TrainingError: if a number is unknown, or percepts of that time are not kept.
        FeatureValueError: see `PerceptHistory.values`.
    """
    commands = trainer.log.commands_of(numbers)
    dues = {command: _then(trainer, command, n, ago) for command, n in commands.items()}
    words = f"{these(commands.values())} due {ago:g} s before its command"
    return trainer.log.replacement(moved(trainer, dues), words)


def moved(trainer: Trainer, dues: Mapping[int, PerceptRecord]) -> list[Example]:
    """Return the examples of commands as they would be if due in other moments.

    Args:
        trainer: the trainer.
        dues: the moment in which each command was due.

    Raises:
        FeatureValueError: see `PerceptHistory.values`.
    """
    found, features = [], trainer.curriculum.features
    for e in trainer.examples:
        window = trainer.history.kept_around(e.command)
        if e.command in dues and window is not None:
            due = dues[e.command]
            values = trainer.history.values(due, features)
            if e.is_default:
                changed = replace(e, features=as_entered(features, values))
            else:
                changed = replace(e, features=values, state=due.state)
            late = max(0.0, window[0] - due.time)
            found.append(replace(changed, cycle=due.cycle, ago=late, readings=due.readings))
    return found


def _then(trainer: Trainer, command: int, example: int, ago: float) -> PerceptRecord:
    """Return the moment a given time before a command."""
    window = trainer.history.kept_around(command)
    if window is None:
        raise TrainingError(
            f"example {example} was recorded in an earlier training, so what was before it is "
            "not known; delete it, and demonstrate it again"
        )
    time, moments = window
    longest = time - moments[0].time
    if ago and longest <= 0.0:
        raise TrainingError(
            f"example {example} was commanded while the world stood still, so its command was "
            "not late; delete it and demonstrate it again if it is wrong"
        )
    if not ago >= 0.0:
        raise TrainingError(
            f"a command cannot have been due {-ago:g} s after it was given; give a number "
            f"from 0 to {longest:.2g}"
        )
    if ago > longest + STEP_SECONDS:
        raise TrainingError(
            f"{ago:g} s is too long ago: what was perceived in the last {longest:.2g} s "
            f"before example {example} is kept; give a number from 0 to {longest:.2g}, or "
            "delete the example and demonstrate it again"
        )
    return nearest(moments, time - ago)
