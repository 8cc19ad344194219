"""What a person can do on the page, one module for each concern."""

from hitab_studio.actions import arranging, correcting, keeping, looking, recording, teaching
from hitab_studio.actions.registry import Wishes, perform

__all__ = [
    "Wishes",
    "arranging",
    "correcting",
    "keeping",
    "looking",
    "perform",
    "recording",
    "teaching",
]
