"""What an agent reports among its faults that is none: notes, which nobody has to act on."""

from __future__ import annotations

RESUMED = "resumed the interrupted training"
"""How the note begins of an agent that was restarted, and goes on with a training."""


def is_note(text: str) -> bool:
    """Whether something among the faults of an agent is only a note."""
    return text.startswith(RESUMED)
