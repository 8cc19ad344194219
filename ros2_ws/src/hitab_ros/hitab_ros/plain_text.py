"""Makes foreign text safe for logs, statuses and terminals."""

from __future__ import annotations

TEXT_MAX = 1000
"""Maximum characters of a text."""


def plain(text: str, limit: int = TEXT_MAX) -> str:
    """Return a text of bounded length without control characters except line ends."""
    if len(text) > limit:
        half = (limit - 5) // 2
        text = f"{text[:half]} ... {text[-half:]}"
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\n" else f"\\x{ord(c):02x}" for c in text)
