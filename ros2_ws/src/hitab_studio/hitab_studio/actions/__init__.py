"""What a person can do on the page, one module for each concern."""

from hitab_studio.actions import arranging, correcting, keeping, looking, recording, teaching
from hitab_studio.actions.registry import perform

__all__ = ["arranging", "correcting", "keeping", "looking", "perform", "recording", "teaching"]
