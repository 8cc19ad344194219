"""Identifiers of a language for the names of behaviors and features."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable


def identifiers(labels: Iterable[str], reserved: Collection[str] = ()) -> dict[str, str]:
    """Return a different identifier for each label.

    Examples:
        >>> identifiers(["DistanceTo(ball)", "A(b, c)", "A(b_c)", "class"], ["class"])
        {'DistanceTo(ball)': 'DistanceTo_ball', 'A(b, c)': 'A_b_c', 'A(b_c)': 'A_b_c_2', \
'class': 'class_2'}
    """
    taken = set(reserved)
    found: dict[str, str] = {}
    for label in labels:
        # Two underscores in a row are reserved in C++.
        plain = name = re.sub(r"[^A-Za-z0-9]+", "_", label).strip("_")
        number = 1
        while name in taken:
            number += 1
            name = f"{plain}_{number}"
        taken.add(name)
        found[label] = name
    return found
