"""Parts of a page's state: missing targets, numbers, the table of examples, a generation."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple


class LostCommand(NamedTuple):
    """A command that its agent may not have received.

    Attributes:
        agent: receiver of the command.
        behavior: the commanded behavior, with targets and numbers.
        id: identity of the command, the same when it is sent again.
    """

    agent: str
    behavior: str
    id: str


@dataclass
class MissingTargets:
    """A commanded behavior that still needs targets, to be clicked in the field.

    Attributes:
        seen: the world's cycle that the page showed at the time of the command.
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
    """Sorting, filters and selection of the table of examples; `hidden` features lack a column."""

    automaton: str = ""
    sort: str = "number"
    descending: bool = False
    text: str = ""
    kind: str = ""
    marked: set[int] = field(default_factory=set)
    hidden: set[str] = field(default_factory=set)


@dataclass
class Making:
    """Progress of making a generation, or of going back to one.

    Attributes:
        agent: the trained agent.
        behavior: the trained behavior.
        doing: present activity, for people; "" once finished.
        said: messages about the finished steps.
        is_to_end: whether a page has requested to stop.
    """

    agent: str
    behavior: str
    doing: str = "beginning"
    said: list[str] = field(default_factory=list)
    is_to_end: bool = False


@dataclass
class TutorialProgress:
    """Progress of a person in the tutorial, which the browser keeps.

    Attributes:
        is_known: whether the browser has told what it keeps.
        is_open: whether the page shows the tutorial.
        is_finished: whether the person has finished the tutorial before.
        passed: names of the steps that stay done.
        step: the last shown step; None before the first.
    """

    is_known: bool = False
    is_open: bool = False
    is_finished: bool = False
    passed: set[str] = field(default_factory=set)
    step: Any = None
