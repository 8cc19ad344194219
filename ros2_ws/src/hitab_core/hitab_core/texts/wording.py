"""Numbers and names in the texts that people read."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache

LISTED_MAX = 5
"""Maximum number of names in a sentence, if nothing else is said."""


def quantity(number: float, noun: str, plural: str = "") -> str:
    """Return a number with its noun, such as ``1 example`` or ``3 examples``.

    Args:
        number: number of things.
        noun: noun for one thing.
        plural: noun for other numbers; by default with an s.

    Examples:
        >>> quantity(1, "example"), quantity(0, "library", "libraries")
        ('1 example', '0 libraries')
    """
    return f"{number} {noun if number == 1 else plural or noun + 's'}"


def numbered(noun: str, numbers: Iterable[int], most: int | None = None) -> str:
    """Name things by their numbers, unless they are many.

    Args:
        noun: noun for one thing.
        numbers: numbers of the things.
        most: maximum number of names; with more, only give their number. None to name all.

    Examples:
        >>> numbered("example", [3]), numbered("example", [5, 4]), numbered("example", [1, 2], 1)
        ('example 3', 'examples 4, 5', '2 examples')
    """
    listed = sorted(numbers)
    if most is not None and len(listed) > most:
        return quantity(len(listed), noun)
    return f"{noun if len(listed) == 1 else noun + 's'} {', '.join(map(str, listed))}"


def some(names: Sequence[str], most: int = LISTED_MAX, between: str = ", ") -> str:
    """Return the first of many names, and the number of the others.

    Examples:
        >>> some(["a", "b", "c"], most=2)
        'a, b and 1 more'
    """
    more = len(names) - most
    return between.join(names[:most]) + (f" and {more} more" if more > 0 else "")


def each_once(texts: Iterable[tuple[str, str]]) -> list[str]:
    """Return each text once, after the names of those whom it concerns.

    Args:
        texts: names and texts, in order.

    Examples:
        >>> each_once([("a", "is late"), ("b", "is gone"), ("c", "is late")])
        ['a, c: is late', 'b: is gone']
    """
    concerned: dict[str, list[str]] = {}
    for name, text in texts:
        concerned.setdefault(text, []).append(name)
    return [f"{some(names)}: {text}" for text, names in concerned.items()]


def in_groups(names: Iterable[str], superiors: Mapping[str, str]) -> list[str]:
    """Return agents by the commander of each group that is complete, and single names.

    Args:
        names: some agents and commanders.
        superiors: the commander of each agent and commander, by name; empty without one.

    Examples:
        >>> in_groups(["c", "a", "b"], {"a": "squad", "b": "squad", "c": "", "squad": ""})
        ['c', 'squad (2 agents)']
    """
    chosen = {*names}
    members: dict[str, set[str]] = {}
    for name, superior in superiors.items():
        members.setdefault(superior, set()).add(name)
    complete = {name for name, group in members.items() if name and group <= chosen}

    def top(name: str) -> str:
        for _ in superiors:  # no more steps, since reports may be in a circle
            name = superiors[name] if superiors.get(name, "") in complete else name
        return name

    agents = Counter(top(name) for name in chosen - members.keys())
    tops = sorted({top(name) for name in chosen}, key=natural)
    return [f"{n} ({quantity(agents[n], 'agent')})" if n in complete else n for n in tops]


@lru_cache(maxsize=8192)
def unbroken(text: str) -> str:
    """Return conditions such that no line ends between a number and its unit.

    Examples:
        >>> unbroken("Range < 5 m and 3 < Speed <= 4 or Near").replace("\u00a0", "~")
        'Range < 5~m and 3 < Speed <= 4 or Near'
    """
    return re.sub(r"(?<=\d) (?!(?:and|or)\b)(?=[^\W\d_]|[%°])", "\u00a0", text)


def natural(name: str) -> tuple[tuple[tuple[bool, int, str], ...], str]:
    """Return a sort key that puts ``keeper_2`` before ``keeper_10``."""
    parts = re.split(r"([0-9]+)", name)
    numbered = tuple((p.isdecimal(), int(p) if p.isdecimal() else 0, p) for p in parts)
    return numbered, name


RADIANS = "rad"
DEGREES = "deg"


def shown_unit(unit: str) -> str:
    """Return the unit in which values of features are shown: angles in degrees."""
    return DEGREES if unit == RADIANS else unit


def shown_value(value: float, unit: str) -> float:
    """Return a value in the unit in which it is shown."""
    return math.degrees(value) if unit == RADIANS else value
