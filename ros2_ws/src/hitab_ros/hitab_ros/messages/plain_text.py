"""Foreign text made safe for logs, statuses and terminals."""

from __future__ import annotations

PLAIN_TEXT_MAX = 1000
"""Maximum number of characters of a text."""


def plain(text: str, limit: int = PLAIN_TEXT_MAX, *, lines: bool = True) -> str:
    """Return a text of bounded length without control characters.

    The text passes `hitab_ros.messages.checks`, so that no receiver drops a message with it.

    Args:
        text: received text.
        limit: maximum number of characters; the middle of a longer text is left out.
        lines: whether to keep line ends, as in a text for people.
    """
    text = _shortened(text, limit)
    if text.isprintable():
        return text
    kept = "\n" if lines else ""
    return _shortened("".join(c if c in kept else _escaped(c) for c in text), limit)


def _escaped(character: str) -> str:
    if character.isprintable():
        return character
    return character.encode("unicode_escape").decode()


def _shortened(text: str, limit: int) -> str:
    if len(text) <= limit:
        return text
    half = (limit - 5) // 2
    return f"{text[:half]} ... {text[-half:]}"
