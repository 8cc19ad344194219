"""Converts actions and orders to rcssserver commands: radians to degrees, y up to y down."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from hitab_world import Action
from keepaway_world import action
from keepaway_world.interception import Order
from keepaway_world.parameters import KeepawayParameters

_SAYABLE = re.compile(r"[0-9A-Za-z().+*/?<>_ -]+")
"""Pattern of the messages that the server accepts."""


def commands_of(
    actions: Mapping[str, Action],
    agents: Sequence[str],
    parameters: KeepawayParameters,
    refused: dict[str, str],
) -> tuple[dict[str, list[str]], dict[str, str]]:
    """Return the keepers' commands and messages, by name.

    Args:
        actions: by agent.
        agents: names of all agents.
        parameters: of the game.
        refused: receives what is wrong with an action, by agent.
    """
    given: dict[str, list[str]] = {}
    said = {}
    for name, (values, message) in actions.items():
        if name not in agents:
            refused[name] = f'no keeper "{name}" (known: {", ".join(agents)})'
            continue
        lines = given[name] = []
        try:
            if command := command_of(values):
                lines.append(command)
        except (ValueError, TypeError) as error:
            refused[name] = f"{name}: {error}; treated as no action"
            continue
        try:
            if message:
                lines.append(say(message, parameters))
                said[name] = message
        except ValueError as error:
            refused[name] = f"{name}: {error}"
    return given, said


def command_of(values: Sequence[float]) -> str:
    """Return the command that an action encodes; "" for no action.

    Raises:
        ValueError: if the action is invalid, see `keepaway_world.action`.
    """
    kind, amount, direction = action.parse(values)
    if kind == action.DASH:
        return dash(amount)
    if kind == action.TURN:
        return turn(amount)
    if kind == action.KICK:
        return kick(amount, direction)
    return ""


def command_of_order(order: Order) -> str:
    """Return the command for a built-in player's order."""
    kind, amount, direction = order
    if kind == "dash":
        return dash(amount)
    return turn(amount) if kind == "turn" else kick(amount, direction)


def dash(power: float) -> str:
    """Return the command to dash with a power from -100 to 100."""
    return f"(dash {_within(power, -100.0, 100.0):.4f})"


def turn(moment: float) -> str:
    """Return the command to turn by ``moment`` rad, counter-clockwise."""
    return f"(turn {_degrees(moment):.4f})"


def kick(power: float, direction: float) -> str:
    """Return the command to kick towards ``direction``, rad, counter-clockwise from the body."""
    return f"(kick {_within(power, 0.0, 100.0):.4f} {_degrees(direction):.4f})"


def say(message: str, parameters: KeepawayParameters) -> str:
    """Return the command to say something.

    Raises:
        ValueError: if the server would not transmit it.
    """
    longest = parameters.say_length
    if not isinstance(message, str) or len(message) > longest:
        raise ValueError(
            f"cannot say {message!r}: a message is text of at most {longest} characters; "
            "it is not heard"
        )
    if not _SAYABLE.fullmatch(message):
        raise ValueError(
            f"cannot say {message!r}: on an rcssserver a message is made of letters, digits, "
            "spaces and ( ) . + - * / ? < > _; it is not heard"
        )
    return f'(say "{message}")'


def _within(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


def _degrees(angle: float) -> float:
    return -math.degrees(_within(angle, -math.pi, math.pi))
