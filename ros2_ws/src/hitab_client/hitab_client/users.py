"""The name of the user of this process."""

from __future__ import annotations

import getpass
import os


def user_name() -> str:
    """Return the user's name, or ``user_12345`` in a container where the user has only an id."""
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return f"user_{os.getuid()}"
