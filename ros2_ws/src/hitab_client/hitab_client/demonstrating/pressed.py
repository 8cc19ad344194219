"""Key actions of a demonstrator, and records of pressed keys."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

from hitab_client.errors import SwarmError
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


class UnseenOutcomes:
    """Outcomes of commands that the person cannot have seen yet.

    If the last command was refused and the person presses undo before seeing that, the undo is not
    meant for the command before.
    """

    def __init__(self) -> None:
        self._taken = defaultdict[str, list[bool]](list)

    def add(self, agent: str, taken: bool) -> None:
        """Note the outcome of a command."""
        self._taken[agent].append(taken)

    def check(self, agent: str, action: str) -> None:
        """Check that an action on the last command would not affect another command.

        Raises:
            SwarmError: if the agent has not taken the last command.
        """
        taken = self._taken[agent][-1:]
        if action == "undo":
            del self._taken[agent][-1:]
        if action in ("undo", "earlier") and taken == [False]:
            raise SwarmError(f"{action} is left out: the last command was not taken")

    @property
    def there(self) -> bool:
        """Whether there are unseen outcomes."""
        return any(self._taken.values())

    def clear(self) -> None:
        """Note that the person has seen all outcomes."""
        self._taken.clear()
