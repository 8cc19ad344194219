"""Texts for unknown names: the known names, and the most similar one."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable

from hitab_core.texts.errors import VocabularyError
from hitab_core.texts.wording import natural

LISTED = 10
"""Maximum number of known names in an error."""


def did_you_mean(wrong: str, names: Iterable[object]) -> str:
    """Return `` Did you mean "x"?`` with a leading space, or nothing if no name is close.

    Examples:
        >>> did_you_mean("gofst", ["GoFast", "Stop"])
        ' Did you mean "GoFast"?'
    """
    by_lower = {str(name).lower(): str(name) for name in names}
    near = difflib.get_close_matches(wrong.lower(), by_lower, n=1, cutoff=0.6)
    return f' Did you mean "{by_lower[near[0]]}"?' if near else ""


def has(names: Iterable[object], *wrong: object) -> str:
    """Return ``(known: a, b, c. Did you mean "a"?)``, the tail of an error about unknown names.

    Of more than `LISTED` names it lists those closest to the wrong one, the closest first, and
    counts the others: ``(known: a, b, ... and 990 more)``. Of none: ``(there are none)``.
    """
    known = sorted({str(name) for name in names}, key=natural)
    if not known:
        return "(there are none)"
    hint = next(filter(None, (did_you_mean(str(name), known) for name in wrong)), "")
    more = len(known) - LISTED
    if more > 0:
        known = _closest(str(wrong[0]), known) if wrong else known[:LISTED]
    rest = f", ... and {more} more" if more > 0 else ""
    return f"(known: {', '.join(known)}{rest}{hint and '.'}{hint})"


def _closest(wrong: str, names: Iterable[str]) -> list[str]:
    compare = difflib.SequenceMatcher(b=wrong.lower())

    def distance(name: str) -> float:
        compare.set_seq1(name.lower())
        return -compare.ratio()

    return sorted(names, key=distance)[:LISTED]


def unknown(what: str, name: str, names: Iterable[object], where: str = "") -> str:
    """Return an error about an unknown name.

    Args:
        what: kind of the name, such as "behavior".
        name: the unknown name.
        names: the known names.
        where: place of the name, such as `` in state "X"``, with a leading space.

    Examples:
        >>> print(unknown("behavior", "gofst", ["Stop", "GoFast"]))
        unknown behavior "gofst" (known: GoFast, Stop. Did you mean "GoFast"?)
    """
    return f'unknown {what} "{name}"{where} {has(names, name)}'


def check_known(what: str, name: str, names: Collection[str], where: str = "") -> None:
    """Check that a name is known.

    Raises:
        VocabularyError: if it is unknown, with the text of `unknown`.
    """
    if name not in names:
        raise VocabularyError(unknown(what, name, names, where))
