"""Persistent faults of a node, by key; a fault is cleared when its cause ends."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from hitab_core import Remedy, quantity
from hitab_ros.messages.plain_text import plain

FAULTS_KEPT_MAX = 50
"""Maximum number of stored faults; the first ones stay."""

FAULTS_SHOWN_MAX = 10
"""Maximum number of faults in a status."""


class Faults:
    """The faults of one node, oldest first.

    Attributes:
        changed: called when a fault appears, changes or is cleared.
        by_key: the texts; read-only.
    """

    def __init__(self, changed: Callable[[], None] = lambda: None) -> None:
        self.changed = changed
        self.by_key: dict[str, str] = {}
        self._remedies: dict[str, tuple[Remedy, ...]] = {}

    def __bool__(self) -> bool:
        return bool(self.by_key)

    def set(self, key: str, text: str, *remedies: Remedy) -> bool:
        """Store a fault until `clear` is called with its key; return whether it is new.

        Args:
            key: the failing part; one fault is stored per key.
            text: the fault for people. An empty text clears the fault.
            remedies: the remedies that a person has.
        """
        if not text:
            self.clear(key)
            return False
        text = plain(text)
        before = self.by_key.get(key)
        if before == text or (before is None and len(self.by_key) >= FAULTS_KEPT_MAX):
            return False
        self.by_key[key], self._remedies[key] = text, remedies
        self.changed()
        return before is None

    def clear(self, key: str) -> None:
        """Remove a fault whose cause has ended."""
        if self.by_key.pop(key, None) is not None:
            self.changed()

    def text(self, key: str) -> str:
        """Return the fault under a key; empty if there is none."""
        return self.by_key.get(key, "")

    @property
    def remedies(self) -> list[Remedy]:
        """Remedies for the faults."""
        return [remedy for key in self.by_key for remedy in self._remedies[key]]

    def texts(self) -> list[str]:
        """Return the faults as a status shows them."""
        return shown(self.by_key.values())


def shown(faults: Iterable[str]) -> list[str]:
    """Return faults as a status shows them: not too many, each of bounded length."""
    texts = [plain(text) for text in faults]
    more = len(texts) - FAULTS_SHOWN_MAX
    return (
        texts if more <= 0 else [*texts[:FAULTS_SHOWN_MAX], f"and {quantity(more, 'more fault')}"]
    )
