"""A lesson: step by step, which agent learns what, as in its YAML file.

    lesson: GotoBall
    agent: keeper_1               # the agent to teach
    budget: 10                    # maximum number of examples, including default ones
    steps:
      - place: {keeper_1: {x: 0, y: 0, heading: 90}, ball: {x: 6, y: 0}}
      - begin: GotoBall
        features: [DirectionTo(ball)]
      - command: TurnToBall
      - until: {bearing: [keeper_1, ball], below: 5}
        within: 3
      - test: true
        restart: true
      - check: {distance: [keeper_1, ball], below: 1.0}
        within: 8
      - save: true

Positions are in m, angles in degrees, times in simulated seconds. `conditions` lists what may
follow `until`, `check` and `never`; every class below is a kind of step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from hitab_client.lessons.conditions import Condition
from hitab_core import Use

WITHIN = 20.0
"""Default simulated seconds within which an awaited condition must hold."""


@dataclass(frozen=True)
class Step:
    """One step; ``line`` is where it stands in the file."""

    kind: ClassVar[str] = ""
    line: int
    agent: str


@dataclass(frozen=True)
class Say(Step):
    """Tell the user what is about to happen."""

    kind: ClassVar[str] = "say"
    text: str


@dataclass(frozen=True)
class Place(Step):
    """Put things somewhere, and let all agents see it."""

    kind: ClassVar[str] = "place"
    things: Mapping[str, Mapping[str, float]]
    new_episode: bool = False


@dataclass(frozen=True)
class Begin(Step):
    """Begin to train an automaton."""

    kind: ClassVar[str] = "begin"
    automaton: str
    features: tuple[str, ...] = ()
    states: tuple[str, ...] = ()
    parameters: Mapping[str, str] = field(default_factory=dict)
    resume: str = ""
    classifier: str = ""


@dataclass(frozen=True)
class Command(Step):
    """Command a behavior."""

    kind: ClassVar[str] = "command"
    use: Use


@dataclass(frozen=True)
class Until(Step):
    """Run the world until a condition holds; it is an error if it does not in time.

    ``wait: 2`` is short for ``until: {seconds: 2}``.
    """

    kind: ClassVar[str] = "until"
    condition: Condition
    within: float = WITHIN


@dataclass(frozen=True)
class Check(Until):
    """The same, as a test of what was learned."""

    kind: ClassVar[str] = "check"


@dataclass(frozen=True)
class Never(Until):
    """Run the world for a while, during which a condition must not hold."""

    kind: ClassVar[str] = "never"


@dataclass(frozen=True)
class Test(Step):
    """Give control to what the agent has learned."""

    kind: ClassVar[str] = "test"
    __test__: ClassVar[bool] = False  # not a test case, despite its name
    restart: bool = False


@dataclass(frozen=True)
class TakeOver(Step):
    """Give control back to the demonstrator."""

    kind: ClassVar[str] = "take_over"


@dataclass(frozen=True)
class Undo(Step):
    """Undo the last command or edit."""

    kind: ClassVar[str] = "undo"


@dataclass(frozen=True)
class Save(Step):
    """Save what was learned; ``keep_unused`` keeps features for training to be resumed later."""

    kind: ClassVar[str] = "save"
    name: str = ""
    bind: Mapping[str, str] = field(default_factory=dict)
    description: str = ""
    keep_unused: bool = False


@dataclass(frozen=True)
class Distribute(Step):
    """Send a behavior to other agents; ``start`` makes them perform it."""

    kind: ClassVar[str] = "distribute"
    use: Use
    receivers: tuple[str, ...] = ()
    start: bool = False


@dataclass(frozen=True)
class Perform(Step):
    """Make agents perform a behavior, or nothing."""

    kind: ClassVar[str] = "perform"
    use: Use | None
    agents: tuple[str, ...]


@dataclass(frozen=True)
class NewEpisode(Step):
    """Begin a new episode with all agents in Start."""

    kind: ClassVar[str] = "new_episode"


@dataclass(frozen=True)
class Lesson:
    """A whole lesson.

    Attributes:
        name: the automaton that it teaches.
        agent: to teach.
        budget: maximum number of examples, including default ones; None: no limit.
    """

    name: str
    file: Path
    agent: str
    steps: tuple[Step, ...]
    budget: int | None = None
    description: str = ""
