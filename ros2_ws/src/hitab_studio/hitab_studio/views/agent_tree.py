"""The tree of agents in the list: under their commanders, or by what they are called."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

FEW = 40
"""Agents that are shown unfolded, and in one row each if nobody commands them."""

DEEPEST = 8


@dataclass(frozen=True)
class Branch:
    """An agent with those that it commands, or a title above agents that are called alike."""

    name: str
    below: tuple[Branch, ...] = ()
    is_agent: bool = True

    @cached_property
    def size(self) -> int:
        """Number of agents in it."""
        return self.is_agent + sum(branch.size for branch in self.below)

    def all(self) -> Iterator[Branch]:
        """Yield it and all below it."""
        yield self
        for branch in self.below:
            yield from branch.all()

    def holds(self, agent: str) -> bool:
        """Whether an agent is somewhere below it."""
        return any(b.name == agent for branch in self.below for b in branch.all())


def tree(agents: Iterable[str], groups: Mapping[str, Any]) -> Sequence[Branch]:
    """Return the agents in a tree.

    Args:
        agents: their names.
        groups: the last `CommanderStatus` of each commander.
    """
    there = tuple(agents)
    commands = tuple((name, tuple(subs)) for name, subs in commanded(groups, there).items())
    return _tree(there, commands)


def commanded(groups: Mapping[str, Any], agents: Iterable[str]) -> dict[str, list[str]]:
    """Return the subordinates of each commander, also of those that were not heard yet.

    A commander names its subordinates and its own commander, so a link between two of them is
    known as soon as one of them was heard.

    Args:
        groups: the last `CommanderStatus` of each commander.
        agents: names of those that should be there; nobody else commands.
    """
    there = {*groups, *agents}
    found = {
        name: [member.name for member in group.subordinates] for name, group in groups.items()
    }
    for name, group in groups.items():
        if group.superior in there and name not in found.get(group.superior, ()):
            found.setdefault(group.superior, []).append(name)
    return found


@lru_cache(maxsize=4)
def _tree(
    agents: tuple[str, ...], commands: tuple[tuple[str, tuple[str, ...]], ...]
) -> tuple[Branch, ...]:
    subordinates = dict(commands)
    below = {sub for subs in subordinates.values() for sub in subs}

    def under(name: str, depth: int) -> Branch:
        subs = subordinates.get(name, ()) if depth < DEEPEST else ()
        return Branch(name, tuple(under(sub, depth + 1) for sub in subs))

    tops = [under(name, 0) for name in agents if name not in below]
    return tuple(tops if len(tops) <= FEW else _by_name(tops))


def _by_name(tops: Sequence[Branch]) -> list[Branch]:
    """Return them with titles above those that differ in their numbers alone."""
    alike: dict[str, list[Branch]] = {}
    for branch in tops:
        alike.setdefault(branch.name.rstrip("0123456789"), []).append(branch)
    found: list[Branch] = []
    for stem, branches in alike.items():
        if len(branches) > 1:
            found.append(Branch(f"{stem}…", tuple(branches), is_agent=False))
        else:
            found += branches
    return found


def unfolded(
    tops: Sequence[Branch], folds: Mapping[str, bool], agent: str
) -> Iterator[tuple[Branch, int, str]]:
    """Yield what is visible: each branch with its depth, and "open" or "closed" if it can be.

    Args:
        tops: the tree.
        folds: what a person has opened (true) or closed, by name.
        agent: the viewed one, which is always visible unless a person has closed what holds it.
    """
    few = sum(branch.size for branch in tops) <= FEW

    def visible(branch: Branch, depth: int) -> Iterator[tuple[Branch, int, str]]:
        if not branch.below:
            yield branch, depth, ""
            return
        is_open = folds.get(branch.name)
        if is_open is None:
            is_open = few or branch.holds(agent)
        yield branch, depth, "open" if is_open else "closed"
        if is_open:
            for sub in branch.below:
                yield from visible(sub, depth + 1)

    for top in tops:
        yield from visible(top, 0)
