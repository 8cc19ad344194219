"""What pages show at present."""

from __future__ import annotations

import time
from collections.abc import Iterable

CAMERA, MAP = "camera", "map"
LEASE_SECONDS = 3.0
"""How long a page shows what it has asked for; while it does, it asks again and again."""


class Viewing:
    """What pages show.

    Attributes:
        focus: the agents that each session views.
        pages: sessions that are connected.
    """

    def __init__(self) -> None:
        self.focus: dict[str, frozenset[str]] = {}
        self.pages: set[str] = set()
        self._leases: dict[tuple[str, str], float] = {}

    def look_at(self, session: str, agents: Iterable[str]) -> None:
        """View these agents on behalf of a session; none means that it has gone."""
        if looked_at := frozenset(agents):
            self.focus[session] = looked_at
        else:
            self.focus.pop(session, None)

    def connect(self, session: str, *, on: bool) -> None:
        """Note that a page is connected from now on, or no longer."""
        if on:
            self.pages.add(session)
        else:
            self.pages.discard(session)

    def lease(self, what: str, agent: str = "") -> None:
        """Note that a page shows the camera of an agent, or the map."""
        self._leases[what, agent] = time.monotonic() + LEASE_SECONDS

    def wanted(self, what: str) -> set[str]:
        """Return the agents whose cameras pages show; of the map, a set with one empty name."""
        now = time.monotonic()
        self._leases = {key: until for key, until in self._leases.items() if until > now}
        return {agent for kind, agent in self._leases if kind == what}
