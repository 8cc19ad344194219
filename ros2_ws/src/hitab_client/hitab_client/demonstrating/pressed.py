"""Keys that a person who trains agents can press, and has pressed."""

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
        what: for people.
        agent: whom it is for.
        behavior: that is commanded, or empty.
        at: when, s, by the demonstrator's clock.
        seen: the world's cycle that the person saw; 0 if unknown.
    """

    what: str
    agent: str
    behavior: str
    at: float
    seen: int


@dataclass(frozen=True)
class Prompt:
    """A behavior of which a target or a number is still to be given.

    Attributes:
        term: the behavior, with its parameters, and what was given so far.
        pressed: the key that commanded it.
        place: of the parameter in question.
        targets: among which to choose.
        number: in question, instead of a parameter, or None.
        typed: of the number so far.
    """

    term: Term
    pressed: Pressed
    place: int = 0
    targets: tuple[str, ...] = ()
    number: BoundedNumber | None = None
    typed: str = ""

    def with_target(self, target: str) -> Term:
        """Return the behavior with a target in the place of the parameter."""
        arguments = list(self.term.arguments)
        arguments[self.place] = target
        return Term(self.term.name, tuple(arguments))


class UnseenOutcomes:
    """Whether agents have taken the commands whose outcomes the person cannot have seen yet.

    A person who presses undo before seeing that the last command was refused does not mean the
    command before.
    """

    def __init__(self) -> None:
        self._taken = defaultdict[str, list[bool]](list)

    def add(self, agent: str, taken: bool) -> None:
        """Note the outcome of a command."""
        self._taken[agent].append(taken)

    def check(self, agent: str, action: str) -> None:
        """Check that what is done to the last command is not done to another.

        Raises:
            SwarmError: if the last one was not taken.
        """
        taken = self._taken[agent][-1:]
        if action == "undo":
            del self._taken[agent][-1:]
        if action in ("undo", "earlier") and taken == [False]:
            raise SwarmError(f"{action} is left out: the command that it was for was not taken")

    @property
    def there(self) -> bool:
        """Whether there are any."""
        return any(self._taken.values())

    def clear(self) -> None:
        """Note that the person sees them."""
        self._taken.clear()
