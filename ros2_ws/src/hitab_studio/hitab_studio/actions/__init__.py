"""What a person can do on the page, one module per concern."""

from hitab_studio.actions import arranging, correcting, looking, recording, saving, teaching
from hitab_studio.actions.registry import Wishes, perform

__all__ = [
    "Wishes",
    "arranging",
    "correcting",
    "looking",
    "perform",
    "recording",
    "saving",
    "teaching",
]
