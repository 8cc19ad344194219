"""Doubts: late commands that may be meant for either of two moments, which a person is asked."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hitab_core.assistant.causes import NEAR
from hitab_core.assistant.lateness import LateCommand
from hitab_core.numeric.arrays import Floats
from hitab_core.training.percepts import PerceptRecord

DOUBT = 0.5
"""A command is doubtful if another moment is at least so many times as probable as its own."""


class Doubt(NamedTuple):
    """A late command that may be meant for either of two moments.

    Attributes:
        time: of the command, s.
        likely: the moment for which it is recorded.
        other: the most probable other moment.
    """

    time: float
    likely: PerceptRecord
    other: PerceptRecord


def doubtful(command: LateCommand, weights: Floats, due: int) -> int | None:
    """Return the most probable other moment of a command, if it is hardly less probable.

    Moments within `NEAR` of each other count together.

    Args:
        command: the command.
        weights: how probable each moment is, and after these each change of state.
        due: index of the moment at which it was due.

    Returns:
        The index of the moment, or of the change of state; None if there is no doubt.
    """
    delays = np.append(command.delays, command.changed)
    changes = np.arange(len(delays)) >= len(command.delays)
    away = np.abs(delays[:, None] - delays)
    alike = changes[:, None] == changes
    near = (away <= NEAR + 1e-6) & alike
    mass = near @ weights
    # The other one must not share any of what speaks for this one.
    apart = (away[due] > 2.0 * NEAR) | ~alike[due]
    most = int(np.where(apart, mass, -1.0).argmax())
    if not apart.any() or mass[most] < DOUBT * mass[due]:
        return None
    return int(np.where(near[most] & apart, weights, -1.0).argmax())
