"""Name and home of this process's user, also if the user is only an id."""

from __future__ import annotations

import getpass
import os
import pwd
from pathlib import Path


def user_name() -> str:
    """Return the user's name, or ``user_12345`` in a container where the user has only an id."""
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return f"user_{os.getuid()}"


def user_home() -> Path:
    """Return the user's home folder, or the root folder without one, as shells do."""
    try:
        return Path(os.environ.get("HOME") or pwd.getpwuid(os.getuid()).pw_dir)
    except KeyError:
        return Path("/")
