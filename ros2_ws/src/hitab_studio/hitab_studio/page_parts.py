"""Parts of a page's state: what it asks for, how it shows the examples, what is being made."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class MissingTargets:
    """A commanded behavior that still needs targets, to be clicked in the field.

    Attributes:
        seen: the world's cycle that the page showed when it was commanded.
    """

    behavior: str
    parameters: tuple[str, ...]
    seen: int = 0
    targets: tuple[str, ...] = ()


@dataclass
class ShownNumbers:
    """A behavior with its targets, and its numbers by name."""

    behavior: str
    values: dict[str, float]


@dataclass
class ExamplesTable:
    """How the table of examples is shown; `hidden` features have no column."""

    automaton: str = ""
    sort: str = "number"
    descending: bool = False
    text: str = ""
    kind: str = ""
    marked: set[int] = field(default_factory=set)
    hidden: set[str] = field(default_factory=set)


@dataclass
class Making:
    """A generation that is being made or gone back to, or was.

    Attributes:
        agent: that is trained.
        behavior: that is trained.
        doing: present activity, for people; empty once it has ended.
        said: what was done so far.
        is_to_end: whether a page has asked to stop it.
    """

    agent: str
    behavior: str
    doing: str = "beginning"
    said: list[str] = field(default_factory=list)
    is_to_end: bool = False
