"""What pages show at present."""

from __future__ import annotations

from collections.abc import Iterable


class Viewing:
    """What pages show.

    Attributes:
        focus: the agents that each session views.
        pages: sessions that are connected.
    """

    def __init__(self) -> None:
        self.focus: dict[str, frozenset[str]] = {}
        self.pages: set[str] = set()

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
