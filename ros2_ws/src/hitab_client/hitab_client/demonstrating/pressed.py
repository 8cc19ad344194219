"""Key actions of a demonstrator, and records of pressed keys."""

from __future__ import annotations

from dataclasses import dataclass

from hitab_core import BoundedNumber, Term

KEY_ACTIONS = {
    "test": "test what was learned; again: take over",
    "undo": "undo the last command",
    "redo": "redo what was undone",
    "earlier": "that was due earlier: have the last command count for 0.2 s before",
    "nothing": "perform nothing; a training stays",
    "save": "save what was trained",
    "previous": "the previous agent",
    "next": "the next agent",
    "stop": "EMERGENCY STOP of all robots; in a simulated world alone, pause or resume it",
    "go": "release them; robots wait",
    "arm": "let the robot act again",
}
"""Key actions besides behaviors."""


@dataclass(frozen=True)
class Pressed:
    """A pressed key or button.

    Attributes:
        what: name of the action, for people.
        agent: name of the agent it is for.
        behavior: the commanded behavior; empty for another action.
        at: time by the demonstrator's clock, s.
        seen: the world's cycle that the person saw; 0 if unknown.
    """

    what: str
    agent: str
    behavior: str
    at: float
    seen: int


@dataclass(frozen=True)
class Prompt:
    """A behavior with a missing target or number.

    Attributes:
        term: behavior with its parameters, and the targets and numbers given so far.
        pressed: key that commanded the behavior.
        place: position of the missing parameter.
        targets: targets to choose from.
        number: missing number, or None if a parameter is missing.
        typed: characters of the number so far.
    """

    term: Term
    pressed: Pressed
    place: int = 0
    targets: tuple[str, ...] = ()
    number: BoundedNumber | None = None
    typed: str = ""

    def with_target(self, target: str) -> Term:
        """Return the behavior with a target for the missing parameter."""
        arguments = list(self.term.arguments)
        arguments[self.place] = target
        return Term(self.term.name, tuple(arguments))
