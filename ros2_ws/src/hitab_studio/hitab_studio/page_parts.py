"""Parts of a page's state: what it asks for, and how it shows the examples."""

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
