"""The tab for recording and for the list of recordings."""

from __future__ import annotations

import time
from typing import Any

from hitab_client.recording.recordings import recordings, recordings_folder
from hitab_studio.pages.page import Page

RECORDINGS_MAX = 30


def context(page: Page) -> dict[str, Any]:
    """Return the variables of the tab's template."""
    known = page.studio.known
    done = [r for r in recordings() if not known.recording.endswith(f"/{r.path.name}")]
    return {
        "folder": str(recordings_folder()),
        "files": [
            (r.path.name, time.strftime("%d %b %H:%M", time.localtime(r.when)), r.size)
            for r in done[:RECORDINGS_MAX]
        ],
        "more": max(0, len(done) - RECORDINGS_MAX),
        "shown": page.player.recording.path.name if page.player is not None else "",
    }
