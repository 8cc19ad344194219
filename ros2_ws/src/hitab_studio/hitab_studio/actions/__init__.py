"""What a person can do on the page, one module per concern."""

from hitab_studio.actions import (
    answering,
    arranging,
    correcting,
    exchanging,
    launching,
    looking,
    recording,
    saving,
    teaching,
    timing,
)
from hitab_studio.actions.registry import Wishes, perform

__all__ = [
    "Wishes",
    "answering",
    "arranging",
    "correcting",
    "exchanging",
    "launching",
    "looking",
    "perform",
    "recording",
    "saving",
    "teaching",
    "timing",
]
