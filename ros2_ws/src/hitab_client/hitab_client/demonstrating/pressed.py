"""What a person who trains agents can press, and has pressed."""

from __future__ import annotations

from dataclasses import dataclass

from hitab_core import Number, Use

ACTIONS = {
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
"""What can be pressed besides behaviors."""


@dataclass(frozen=True)
class Pressed:
    """What a person has pressed.

    Attributes:
        what: for people.
        agent: whom it is for.
        behavior: that is commanded; empty: none.
        at: when, s, by the demonstrator's clock.
        due: when what it answers was seen, s; differs from `at` if more had to be given first.
        seen: the world's cycle that the person saw; 0: unknown.
    """

    what: str
    agent: str
    behavior: str
    at: float
    due: float
    seen: int


@dataclass(frozen=True)
class Asked:
    """A behavior of which a target or a number is still to be given.

    Attributes:
        use: the behavior, with its parameters, and what was given so far.
        pressed: the key that commanded it.
        place: of the parameter in question.
        targets: among which to choose.
        number: in question, instead of a parameter; None: none.
        typed: of the number so far.
    """

    use: Use
    pressed: Pressed
    place: int = 0
    targets: tuple[str, ...] = ()
    number: Number | None = None
    typed: str = ""

    def with_target(self, target: str) -> Use:
        """Return the behavior with a target in the place of the parameter."""
        arguments = list(self.use.arguments)
        arguments[self.place] = target
        return Use(self.use.name, tuple(arguments))
