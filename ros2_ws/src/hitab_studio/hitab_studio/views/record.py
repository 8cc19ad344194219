"""Recordings: making one, and the list of existing ones."""

from __future__ import annotations

import time
from typing import Any

from hitab_studio.recording import recordings_folder
from hitab_studio.session import Session

MOST = 30


def context(session: Session) -> dict[str, Any]:
    """Return what the tab shows."""
    store = session.shared.store
    found = []
    for path in recordings_folder().glob("*.mcap"):
        try:
            stat = path.stat()
        except OSError:
            continue
        found.append((stat.st_mtime, path.name, stat.st_size / 1e6))
    found.sort(reverse=True)
    return {
        "recording": store.known.recording,
        "recorded": store.known.recorded,
        "folder": str(recordings_folder()),
        "files": [
            (name, time.strftime("%d %b %H:%M", time.localtime(when)), size)
            for when, name, size in found[:MOST]
            if not store.known.recording.endswith(name)
        ],
    }
