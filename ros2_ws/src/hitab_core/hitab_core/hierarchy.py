"""Which behavior uses which: order and cycles, visiting each behavior once.

Behaviors are shared, so a hierarchy may have far more paths than behaviors.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

Uses = Callable[[str], Iterable[str]]
"""Returns the names of what a behavior uses; nothing for a basic behavior."""


def in_order(names: Iterable[str], uses: Uses) -> list[str]:
    """Return behaviors and everything they are made of, each after what it uses.

    Raises:
        ValueError: if one uses itself; see `circle_among`.
    """
    order, circle = _visit(names, uses)
    if circle:
        raise ValueError(f"{' -> '.join(circle)} is a circle")
    return order


def circle_among(names: Iterable[str], uses: Uses) -> list[str]:
    """Return a path from a reachable behavior back to itself, if there is one.

    Returns:
        ``[A, B, A]`` where A uses B and B uses A; empty if no behavior uses itself.
    """
    return _visit(names, uses)[1]


def _visit(names: Iterable[str], uses: Uses) -> tuple[list[str], list[str]]:
    """Visit depth first; return the order and the first cycle, if any."""
    order: list[str] = []
    done: set[str] = set()
    for name in names:
        if name in done:
            continue
        # The path down, each behavior with what remains to be visited below it; no recursion,
        # since a hierarchy may be deeper than Python's stack.
        way: dict[str, Iterator[str]] = {name: iter(sorted(uses(name)))}
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
                way[below] = iter(sorted(uses(below)))
    return order, []


def circular(names: Iterable[str], uses: Uses) -> dict[str, int]:
    """Return the behaviors that use themselves, directly or through others, by group.

    Two of them are in the same group if each uses the other. Source: R. Tarjan, Depth-first
    search and linear graph algorithms, 1972.
    """
    number: dict[str, int] = {}
    low: dict[str, int] = {}
    open_: dict[str, None] = {}
    groups: dict[str, int] = {}
    for name in names:
        if name in number:
            continue
        way: list[tuple[str, Iterator[str]]] = []

        def enter(entered: str, way: list[tuple[str, Iterator[str]]] = way) -> None:
            number[entered] = low[entered] = len(number)
            open_[entered] = None
            way.append((entered, iter(uses(entered))))

        enter(name)
        while way:
            last, below = way[-1]
            for used in below:
                if used == last:
                    groups.setdefault(last, number[last])
                elif used not in number:
                    enter(used)
                    break
                elif used in open_:
                    low[last] = min(low[last], number[used])
            else:
                way.pop()
                if way:
                    low[way[-1][0]] = min(low[way[-1][0]], low[last])
                if low[last] == number[last]:
                    _close(last, open_, groups, number[last])
    return groups


def _close(first: str, open_: dict[str, None], groups: dict[str, int], group: int) -> None:
    """Close a group: all nodes opened since its first member."""
    members: list[str] = []
    while not members or members[-1] != first:
        members.append(open_.popitem()[0])
    if len(members) > 1:
        groups.update(dict.fromkeys(members, group))
