"""What a person can do on the page, one module per concern."""

from hitab_studio.actions import (
    answering,
    arranging,
    bootstrapping,
    correcting,
    exchanging,
    labeling,
    launching,
    library_changes,
    looking,
    recording,
    saving,
    stopping,
    teaching,
    timing,
)
from hitab_studio.actions.registry import ACTIONS, REPEATED, URGENT, Data

__all__ = [
    "ACTIONS",
    "REPEATED",
    "URGENT",
    "Data",
    "answering",
    "arranging",
    "bootstrapping",
    "correcting",
    "exchanging",
    "labeling",
    "launching",
    "library_changes",
    "looking",
    "recording",
    "saving",
    "stopping",
    "teaching",
    "timing",
]
