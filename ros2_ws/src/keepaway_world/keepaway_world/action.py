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
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # an agent needs no world
    from hitab_world import Action

NONE, DASH, TURN, KICK = 0.0, 1.0, 2.0, 3.0

Order = tuple[str, float, float]
"""("dash", power, 0), ("turn", moment, 0), ("kick", power, direction) or ("none", 0, 0); of a
goalie also ("catch", direction, 0)."""

_ACTION_KINDS = {NONE: ("none", 1), DASH: ("dash", 2), TURN: ("turn", 2), KICK: ("kick", 3)}


class ActionError(ValueError):
    """An action that is not valid."""


def parse(values: Sequence[float]) -> Order:
    """Return the command that ``values`` encode.

    Raises:
        ActionError: if the kind is unknown, or if a value is missing or not finite.
    """
    if len(values) == 0:
        return "none", 0.0, 0.0
    if values[0] not in _ACTION_KINDS:
        known = ", ".join(f"{number:g} {name}" for number, (name, _) in _ACTION_KINDS.items())
        raise ActionError(f"unknown kind of action {values[0]} (known: {known})")
    kind, length = _ACTION_KINDS[values[0]]
    if len(values) < length:
        raise ActionError(f"a {kind} has {length} values, not {len(values)}: {list(values)}")
    amount, direction = (float(value) for value in (*values[1:length], 0.0, 0.0)[:2])
    if not (math.isfinite(amount) and math.isfinite(direction)):
        raise ActionError(f"a {kind} needs finite values, not {list(values)}")
    return kind, amount, direction


def orders_of(
    actions: Mapping[str, Action],
    agents: Sequence[str],
    say_length: int,
    refused: dict[str, str],
) -> Iterator[tuple[str, Order, str]]:
    """Yield each keeper's action and message, in the order of the agents.

    Args:
        actions: the actions by agent.
        agents: names of all agents.
        say_length: length of the longest message.
        refused: receives the faults of actions, by agent.
    """
    for name in agents:
        if name not in actions:
            continue
        try:
            values, say = actions[name]
            order = parse(values)
        except (ValueError, TypeError) as error:
            refused[name] = f"{name}: {error}; treated as no action"
            continue
        if say and not (isinstance(say, str) and len(say) <= say_length):
            refused[name] = (
                f"{name}: cannot say {say!r}: a message is text of at most {say_length} "
                "characters; it is not heard"
            )
            say = ""
        yield name, order, say
    for name in actions:
        if name not in agents:
            refused[name] = f'no agent "{name}" (known: {", ".join(agents)})'
