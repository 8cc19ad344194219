"""What an agent reports among its faults: faults, and notes that are none."""

from __future__ import annotations

from typing import Any

RESUMED = "resumed the interrupted training"
"""How the note of an agent begins that was restarted; see its node."""


def lasting_faults(status: Any) -> list[str]:
    """Return what is wrong with an agent."""
    return [text for text in status.faults if not text.startswith(RESUMED)]


def resumed(status: Any) -> str:
    """Return what an agent has resumed, until it does something else; "" if nothing."""
    if status is None:
        return ""
    return next((text for text in status.faults if text.startswith(RESUMED)), "")


def last_error(status: Any) -> str:
    """Return the last refusal of an agent, or what is wrong with it; "" if nothing is."""
    return "" if status.last_error.startswith(RESUMED) else status.last_error
