"""The action of a keeper, as a short list of floats: at most one command of rcssserver.

====================  ====================================================================
values                command
====================  ====================================================================
``[]`` or ``[0]``     none
``[1, power]``        dash along the body, power from -100 to 100
``[2, moment]``       turn by ``moment`` rad, from -pi to pi; less at higher speed
``[3, power, dir]``   kick, power from 0 to 100, towards ``dir`` rad relative to the body
====================  ====================================================================

Values out of range are clipped, as in the server; extra values are ignored.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

NONE, DASH, TURN, KICK = 0.0, 1.0, 2.0, 3.0

_LENGTHS = {NONE: 1, DASH: 2, TURN: 2, KICK: 3}
_NAMES = {NONE: "none", DASH: "dash", TURN: "turn", KICK: "kick"}


class ActionError(ValueError):
    """An action that is not valid."""


Command = tuple[float, float, float]
"""Kind, power or moment, direction."""

NO_COMMAND: Command = (NONE, 0.0, 0.0)


def parse(values: Sequence[float]) -> Command:
    """Return the command that ``values`` encode.

    Raises:
        ActionError: if the kind is unknown, or a value is missing or not finite.
    """
    if len(values) == 0:
        return NO_COMMAND
    kind = values[0]
    length = _LENGTHS.get(kind)
    if length is None:
        known = ", ".join(f"{number:g} {name}" for number, name in _NAMES.items())
        raise ActionError(f"unknown kind of action {kind} (known: {known})")
    if len(values) < length:
        raise ActionError(
            f"a {_NAMES[kind]} has {length} values, not {len(values)}: {list(values)}"
        )
    if length == 1:
        return NO_COMMAND
    amount = values[1]
    direction = values[2] if length == 3 else 0.0
    if not (math.isfinite(amount) and math.isfinite(direction)):
        raise ActionError(f"a {_NAMES[kind]} needs finite values, not {list(values)}")
    return float(kind), float(amount), float(direction)
