"""Whether a world that should play rests, and why."""

from __future__ import annotations

from collections.abc import Callable

from hitab_msgs.msg import WorldState, WorldStatus

from hitab_client.errors import SwarmError
from hitab_core import Fix
from hitab_ros.messages.conversions import remedies_of


class Rest:
    """Finds whether a world rests too early, after a request to play.

    Args:
        status: function that returns the last status of the world; None if there was none.
    """

    def __init__(self, status: Callable[[], WorldStatus | None]) -> None:
        self._status = status
        self._last, self._new = status(), 0

    def look(self) -> WorldStatus | None:
        """Return the last status if it was sent since the request and the world rests."""
        status = self._status()
        self._new += status is not self._last
        self._last = status
        if status is None or status.mode != WorldState.PAUSED:
            return None
        return status if self._new > 1 else None  # the first one may have been sent before

    def error(self, what: str) -> SwarmError:
        """Return an error that tells where the world rests, why, and how it plays on."""
        status = self._last
        assert status is not None
        why = status.held or status.last_error or "it was paused"
        ways = [Fix.RESUME_WORLD()] if status.held else remedies_of(status.remedies)
        return SwarmError(f"{what}, but rests at cycle {status.cycle}: {why}", *ways)
