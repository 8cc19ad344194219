"""Retiming: have commands been due at another time, so that their examples show what was then."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from hitab_core.automaton import as_entered
from hitab_core.errors import TrainingError
from hitab_core.example import Example
from hitab_core.training.example_log import ExampleLog, these
from hitab_core.training.percept_history import STEP_SECONDS, PerceptHistory
from hitab_core.training.percepts import PerceptRecord, nearest
from hitab_core.training.undo import Edit
from hitab_core.use import Use


def retiming(
    log: ExampleLog,
    kept: PerceptHistory,
    numbers: Iterable[int],
    ago: float,
    features: Sequence[Use],
) -> Edit:
    """Prepare to have commands been due at another time.

    Args:
        log: of the examples.
        kept: what was perceived around each command.
        numbers: of examples; each stands for its command.
        ago: how long before the command it was due, s.
        features: of the automaton in training.

    Raises:
        TrainingError: if one of the numbers is unknown, or what was then is not kept.
        FeatureValueError: as `PerceptHistory.values`.
    """
    commands = log.commands_of(numbers)
    dues = {command: _then(kept, command, n, ago) for command, n in commands.items()}
    words = f"{these(commands.values())} due {ago:g} s before its command"
    return log.replacement(moved(log, kept, dues, features), words)


def moved(
    log: ExampleLog,
    kept: PerceptHistory,
    dues: Mapping[int, tuple[float, PerceptRecord]],
    features: Sequence[Use],
) -> list[Example]:
    """Return the examples of commands as they are if these were due in other moments.

    Args:
        log: of the examples.
        kept: what was perceived around each command.
        dues: when each command was given, s, and the moment in which it was due.
        features: of the automaton in training.

    Raises:
        FeatureValueError: as `PerceptHistory.values`.
    """
    found = []
    for e in log.examples:
        if e.command in dues:
            given, due = dues[e.command]
            values = kept.values(due, features)
            found.append(
                replace(
                    e,
                    state=e.state if e.is_default else due.state,
                    features=as_entered(features, values) if e.is_default else values,
                    cycle=due.cycle,
                    ago=max(0.0, given - due.time),
                    readings=due.readings,
                )
            )
    return found


def _then(
    kept: PerceptHistory, command: int, example: int, ago: float
) -> tuple[float, PerceptRecord]:
    """Return when a command was given, and the moment so long before."""
    window = kept.kept_around(command)
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
    return time, nearest(moments, time - ago)
