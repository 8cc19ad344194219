"""The emergency stop of all robots: its button, and who has engaged it."""

from __future__ import annotations

import time
from typing import Any

from hitab_studio.session import Session


def context(session: Session) -> dict[str, Any]:
    """Return what the button and the band below the header show."""
    known = session.shared.store.known
    stop = known.emergency if known.is_stopped else None
    return {
        "stop": stop,
        "since": time.strftime("%H:%M:%S", time.localtime(stop.stamp.sec)) if stop else "",
        # Agents in no simulated world drive robots that can do harm.
        "robots": bool(known.statuses) and known.world is None,
    }
