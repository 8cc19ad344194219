"""What a person can do on the page, one module per concern."""

from hitab_studio.actions import (
    answering,
    arranging,
    bootstrapping,
    correcting,
    exchanging,
    launching,
    library_changes,
    looking,
    recording,
    saving,
    stopping,
    teaching,
    timing,
)
from hitab_studio.actions.registry import RequestQueue, is_urgent, perform

__all__ = [
    "RequestQueue",
    "answering",
    "arranging",
    "bootstrapping",
    "correcting",
    "exchanging",
    "is_urgent",
    "launching",
    "library_changes",
    "looking",
    "perform",
    "recording",
    "saving",
    "stopping",
    "teaching",
    "timing",
]
