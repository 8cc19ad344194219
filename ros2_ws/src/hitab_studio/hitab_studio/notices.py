"""What an agent reports among its faults: faults, and notes that are none."""

from __future__ import annotations

from typing import Any

from hitab_ros.notes import is_note


def lasting_faults(status: Any) -> list[str]:
    """Return what is wrong with an agent."""
    return [text for text in status.faults if not is_note(text)]


def resumed(status: Any) -> str:
    """Return what an agent has resumed, until it does something else; "" if nothing."""
    if status is None:
        return ""
    return next((text for text in status.faults if is_note(text)), "")


def last_error(status: Any) -> str:
    """Return the last refusal of an agent, or what is wrong with it; "" if nothing is."""
    return "" if is_note(status.last_error) else status.last_error
