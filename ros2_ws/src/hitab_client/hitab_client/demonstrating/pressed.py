"""What a person who trains agents can press, and has pressed."""

from __future__ import annotations

from dataclasses import dataclass

from hitab_core import Use

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
        due: when what it answers was seen, s; differs from `at` if a target was asked for.
        seen: the world's cycle that the person saw; 0: unknown.
    """

    what: str
    agent: str
    behavior: str
    at: float
    due: float
    seen: int


@dataclass(frozen=True)
class TargetsAsked:
    """A behavior whose next target is still to be chosen.

    Attributes:
        use: the behavior, with its parameters and the targets chosen so far.
        place: of the parameter in question.
        pressed: the key that commanded it.
        targets: among which to choose.
    """

    use: Use
    place: int
    pressed: Pressed
    targets: tuple[str, ...]
