"""Texts of learned behaviors, and the obstacles to an agent's command."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hitab_client import console
from hitab_client.terminal.cli_remedies import with_commands

if TYPE_CHECKING:
    from hitab_client import Learned


def plain(message: Any, fields: str) -> dict[str, Any]:
    """Return fields of a message as plain data; their names are separated by spaces."""
    found = {field: getattr(message, field) for field in fields.split()}
    simple = (bool, int, float, str)
    return {f: value if isinstance(value, simple) else list(value) for f, value in found.items()}


def as_text(learned: Learned) -> str:
    """Return the states, transitions and trees of a learned behavior."""
    from hitab_core import automaton_as_text

    if not learned.transitions:
        return f"{learned.name}: nothing can be shown; it has no example, or another classifier"
    return automaton_as_text(learned)


def tell_faults(status: Any) -> None:
    """Print the faults that keep an agent from its last command, such as an emergency stop.

    Args:
        status: the agent's status.
    """
    from hitab_ros.messages.conversions import remedies_of

    if status.faults:
        faults = "\n".join(f"but: {fault}" for fault in status.faults)
        console.note(with_commands(faults, remedies_of(status.remedies)))
