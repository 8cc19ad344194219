"""Numbers in the texts that people read."""

from __future__ import annotations


def quantity(number: int, noun: str, plural: str = "") -> str:
    """Return a number with its noun, such as ``1 example`` or ``3 examples``.

    Args:
        number: how many there are.
        noun: for one.
        plural: for all other numbers; the noun with an s, if not given.

    Example:
        >>> quantity(1, "example"), quantity(0, "library", "libraries")
        ('1 example', '0 libraries')
    """
    return f"{number} {noun if number == 1 else plural or noun + 's'}"
