"""Order and cycles of behaviors that use each other, visiting each behavior once.

Behaviors are shared, so a hierarchy may have far more paths than behaviors.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

Terms = Callable[[str], Iterable[str]]
"""Returns the names of the behaviors that a behavior uses; none for a basic one."""


def in_order(names: Iterable[str], terms: Terms) -> list[str]:
    """Return behaviors and everything they are made of, each after its parts.

    Raises:
        ValueError: if one uses itself; see `circle_among`.
    """
    order, circle = _visit(names, terms)
    if circle:
        raise ValueError(f"{' -> '.join(circle)} is a circle")
    return order


def circle_among(names: Iterable[str], terms: Terms) -> list[str]:
    """Return a path from a reachable behavior back to itself, if there is one.

    Returns:
        ``[A, B, A]`` where A uses B and B uses A; empty if no behavior uses itself.
    """
    return _visit(names, terms)[1]


def _visit(names: Iterable[str], terms: Terms) -> tuple[list[str], list[str]]:
    """Visit depth first; return the order and the first cycle, if any."""
    order: list[str] = []
    done: set[str] = set()
    for name in names:
        if name in done:
            continue
        # The path down, each behavior with the parts still to be visited; no recursion,
        # since a hierarchy may be deeper than Python's stack.
        way: dict[str, Iterator[str]] = {name: iter(sorted(terms(name)))}
        while way:
            last = next(reversed(way))
            below = next(way[last], None)
            if below is None:
                del way[last]
                done.add(last)
                order.append(last)
            elif below in way:
                passed = list(way)
                return order, [*passed[passed.index(below) :], below]
            elif below not in done:
                way[below] = iter(sorted(terms(below)))
    return order, []
