"""How late a person's commands come: the reaction time of each demonstrator, kept on this machine.

An agent records a command with the situation of some time ago, in simulated time, counted from the
world's cycle that the person saw. This module knows the person's time and converts it.
"""

from __future__ import annotations

import math
import random
import statistics
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from hitab_client.errors import SwarmError
from hitab_client.run_folder import state_home
from hitab_core import Do, newer_format
from hitab_core.library.durable_files import file_errors, write_durably

if TYPE_CHECKING:
    from hitab_msgs.msg import WorldStatus

LONGEST = 3.0
"""Nobody who looks at the screen takes longer to react, s."""

ROUNDS = 6
"""Signals of the game that measures the reaction time; it takes about ten seconds."""

FORMAT = 1


def file() -> Path:
    """Return the file that holds the reaction times."""
    return state_home() / "reaction_times.yaml"


def kept() -> Mapping[str, float]:
    """Return the reaction time of each demonstrator, s.

    Raises:
        SwarmError: if the file cannot be read, or does not hold reaction times.
    """
    import yaml

    path = file()
    if not path.exists():
        return {}
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        if content["format"] > FORMAT:
            raise SwarmError(f"{path} {newer_format(content['format'], FORMAT)}")
        found = {str(name): float(s) for name, s in content["seconds"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, yaml.YAMLError) as error:
        raise SwarmError(
            f"{path} does not hold reaction times ({error}); correct it, or delete it",
            Do.MEASURE_REACTION(),
        ) from None
    for seconds in found.values():
        check(seconds)
    return found


def of(demonstrator: str) -> float:
    """Return a demonstrator's reaction time, s; 0 if none is kept.

    Raises:
        SwarmError: as `kept`.
    """
    return kept().get(demonstrator, 0.0)


def keep(demonstrator: str, seconds: float | None) -> None:
    """Keep a demonstrator's reaction time; None: forget it.

    Raises:
        SwarmError: if it is no reaction time, or the file cannot be read.
        LibraryError: if the file cannot be written.
    """
    import yaml

    times = dict(kept())
    if seconds is None:
        times.pop(demonstrator, None)
    else:
        times[demonstrator] = check(seconds)
    text = "# How late the commands of each demonstrator come; see `hitab reaction --help`.\n"
    text += yaml.safe_dump({"format": FORMAT, "seconds": times}, sort_keys=False)
    with file_errors(file(), "write"):
        write_durably(file(), text.encode())


def check(seconds: float) -> float:
    """Return a reaction time if it can be one.

    Raises:
        SwarmError: if it cannot.
    """
    if not 0.0 <= seconds <= LONGEST:
        wrong = "too long" if seconds > 0 else "not possible"
        raise SwarmError(
            f"a reaction time of {seconds:g} s is {wrong}: give a number from 0 to {LONGEST:g}",
            Do.MEASURE_REACTION(),
        )
    return seconds


def simulated(seconds: float, status: WorldStatus | None, speed: float = 1.0) -> float:
    """Return how much simulated time passes for a person in some time of their own.

    Args:
        seconds: of the person.
        status: of the world; None: there is none, or it is a robot's, where time is the person's.
        speed: of a world in lockstep, as seen: simulated seconds in a second.
    """
    if status is None:
        return seconds
    if status.mode == "paused":
        return 0.0  # the situation waits for the person
    return seconds * (status.factor if status.pace == "realtime" else speed)


def measured(
    signal: Callable[[], None],
    pressed: Callable[[float], float | None],
) -> float:
    """Measure a person's reaction time: they press a key at each signal.

    Args:
        signal: gives the signal.
        pressed: waits for the key, for so many seconds at most; returns when it was pressed, by
            the monotonic clock, or None.

    Returns:
        The median, s, to a hundredth.

    Raises:
        SwarmError: if the key was not pressed in half of the rounds.
    """
    times = []
    for _ in range(ROUNDS):
        while pressed(random.uniform(0.8, 2.0)) is not None:
            pass  # too early
        signal()
        shown = time.monotonic()
        at = pressed(LONGEST)
        if at is not None:
            times.append(at - shown)
    if len(times) < math.ceil(ROUNDS / 2):
        raise SwarmError("the key was pressed too rarely; try again", Do.MEASURE_REACTION())
    return check(round(statistics.median(times), 2))
