"""The action of a forager, as a short list of floats: ``[drive, turn, grip]``.

======  =====================================================================================
value   meaning
======  =====================================================================================
drive   speed of walking or pulling along the body: -1 to 1, as a fraction of the maximum
turn    angle to turn by, rad, counter-clockwise
grip    0: as before; -1: let go of the held box; n >= 1: grip box number n; nothing happens
        unless it is in reach and nothing is held
======  =====================================================================================

An empty action means no action; values beyond a robot's limits are clipped.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

DRIVE, TURN, GRIP = range(3)
ACTION_LENGTH = 3
RELEASE = -1.0

Commands = NDArray[np.float64]
"""Shape (foragers, 3): drive, turn, grip."""


def parse_all(
    actions: Mapping[str, tuple[Sequence[float], str]], index: Mapping[str, int]
) -> tuple[Commands, dict[str, str]]:
    """Return the actions of all foragers, and the refused ones by agent.

    Args:
        actions: the actions by agent; agents that are missing do nothing.
        index: row of each forager.
    """
    commands = np.zeros((len(index), ACTION_LENGTH))
    refused: dict[str, str] = {}
    for name, action in actions.items():
        if name not in index:
            refused[name] = f'no robot "{name}" (has {len(index)}: {next(iter(index))} and so on)'
            continue
        try:
            if len(values := action[0]):
                drive, turn, grip = values
                # NaN or infinity makes the sum not finite.
                if not math.isfinite(drive + turn + grip):
                    raise ValueError("needs finite values")
                commands[index[name]] = drive, turn, grip
        except (TypeError, ValueError) as error:
            refused[name] = (
                f"{name}: an action must be drive, turn and grip, not {_shown(action)}: {error}; "
                "treated as no action"
            )
    return commands, refused


def _shown(action: object) -> str:
    text = repr(action[0] if isinstance(action, tuple) and action else action)
    return text if len(text) <= 60 else f"{text[:57]}..."
