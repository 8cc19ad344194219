"""What a person can do on the page, one module per concern."""

from hitab_studio.actions import (
    arranging,
    correcting,
    launching,
    looking,
    recording,
    saving,
    teaching,
)
from hitab_studio.actions.registry import Wishes, perform

__all__ = [
    "Wishes",
    "arranging",
    "correcting",
    "launching",
    "looking",
    "perform",
    "recording",
    "saving",
    "teaching",
]
