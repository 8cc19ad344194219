"""Which key commands which behavior: a key stays with its behavior, whatever else appears."""

from __future__ import annotations

from collections.abc import Container, Iterable

from hitab_core import FLAGS, Use

KEYS = "1234567890qweiopsghjkcvm"
"""Keys of behaviors, in the order in which they are given; other keys have other meanings."""

FLAG_KEYS = dict(zip(FLAGS, "dx", strict=True))
"""Keys of the flags, which every training has."""


def in_order(behaviors: Iterable[str], trained: Container[str]) -> list[str]:
    """Return behaviors in the order in which they get keys: those of the domain first.

    Args:
        behaviors: with parameters, such as ``GoTo(A)``.
        trained: names of those that were trained.
    """
    return sorted(behaviors, key=lambda b: (Use.parse(b).name in trained, b))


class Keys:
    """The keys of the behaviors of each domain."""

    def __init__(self) -> None:
        self._given: dict[str, dict[str, str]] = {}

    def give(self, domain: str, behaviors: Iterable[str]) -> None:
        """Give each behavior that has no key the next one, as long as there are any."""
        given = self._given.setdefault(domain, {})
        for behavior in behaviors:
            if behavior not in given and behavior not in FLAG_KEYS and len(given) < len(KEYS):
                given[behavior] = KEYS[len(given)]

    def of(self, domain: str, behavior: str) -> str:
        """Return the key of a behavior; "" if it has none."""
        return FLAG_KEYS.get(behavior) or self._given.get(domain, {}).get(behavior, "")
