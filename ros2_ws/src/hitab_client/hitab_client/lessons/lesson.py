"""Lessons: steps that teach an agent an automaton, and their YAML format.

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

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import Field, PlainValidator

from hitab_client.errors import LessonError
from hitab_client.lessons.conditions import Condition, Passed
from hitab_core import Term
from hitab_core.library.yaml_models import (
    NONE_IS_EMPTY,
    Format,
    Names,
    OneOf,
    Record,
    Texts,
    open_record,
    read_use,
)
from hitab_core.library.yaml_places import read_text, read_yaml

LESSON_FORMAT = 2
"""The newest format version that is read; 2 has the condition `feature`."""

WITHIN = 20.0
"""Default simulated seconds within which an awaited condition must hold."""


def _term_or_none(text: Any) -> Term | None:
    return None if text == "nothing" else read_use(str(text))


Behavior = Annotated[Term, PlainValidator(lambda text: read_use(str(text)))]


class ThingPlacement(Record):
    """Placement of a thing; the heading is in degrees."""

    x: float | None = None
    y: float | None = None
    heading: float | None = None
    vx: float | None = None
    vy: float | None = None


Things = Annotated[dict[str, ThingPlacement], NONE_IS_EMPTY]


def placed(things: Mapping[str, ThingPlacement]) -> dict[str, dict[str, float]]:
    """Return the given coordinates of things, in the world's units."""
    fields = {name: thing.model_dump(exclude_none=True) for name, thing in things.items()}
    for place in fields.values():
        if "heading" in place:
            place["heading"] = math.radians(place["heading"])
    return fields


class Step(Record):
    """One step; ``line`` is its line in the file, ``kind`` its first key."""

    kinds: ClassVar[dict[str, type[Step]]] = {}
    kind: ClassVar[str] = ""
    line: int = Field(default=0, alias=":line")
    agent: str = ""

    @classmethod
    def __pydantic_init_subclass__(cls, **more: Any) -> None:
        cls.kind = re.sub("(?<=[a-z])(?=[A-Z])", "_", cls.__name__).lower()
        cls.kinds[cls.kind] = cls


class Say(Step):
    """Show a text to the user."""

    text: str = Field(alias="say")


class Place(Step):
    """Place things, and let all agents perceive the change."""

    where: Things = Field(alias="place")
    new_episode: bool = False

    @property
    def things(self) -> dict[str, dict[str, float]]:
        """Placements of things by name, in the world's units."""
        return placed(self.where)


class Begin(Step):
    """Begin to train an automaton."""

    automaton: str = Field(alias="begin")
    features: Texts = ()
    states: Texts = ()
    parameters: Names = Field(default_factory=dict)
    resume: str = ""
    classifier: str = ""


class Command(Step):
    """Command a behavior."""

    term: Behavior = Field(alias="command")


class Until(Step):
    """Run the world until a condition holds; a timeout is an error."""

    condition: Condition = Field(alias="until")
    within: float = Field(default=WITHIN, gt=0.0)


class Check(Until):
    """Run the world until a condition holds, as a test of the learned behavior."""

    condition: Condition = Field(alias="check")


class Never(Until):
    """Run the world for a while, during which a condition must not hold."""

    condition: Condition = Field(alias="never")


class Wait(Step):
    """Shorthand for ``until: {seconds: 2}``, which replaces it."""

    seconds: float = Field(alias="wait", gt=0.0)


class Test(Step):
    """Give control to the learned behavior."""

    __test__: ClassVar[bool] = False  # not a test case, despite its name
    test: Any
    restart: bool = False


class TakeOver(Step):
    """Give control back to the demonstrator."""

    take_over: Any


class Undo(Step):
    """Undo the last command or edit."""

    undo: Any


class Save(Step):
    """Save the learned behavior; ``keep_unused`` keeps unused features for later training."""

    save: Any
    name: str = ""
    bind: Names = Field(default_factory=dict)
    description: str = ""
    keep_unused: bool = False


class Distribute(Step):
    """Send a behavior to other agents; ``start`` makes them perform it."""

    term: Behavior = Field(alias="distribute")
    receivers: Texts = ()
    start: bool = False


class Perform(Step):
    """Make agents perform a behavior, or nothing."""

    term: Annotated[Term | None, PlainValidator(_term_or_none)] = Field(alias="perform")
    agents: Texts = ()


class NewEpisode(Step):
    """Begin a new episode with all agents in Start."""

    new_episode: Any


@dataclass(frozen=True)
class Lesson:
    """A complete lesson.

    Attributes:
        name: name of the automaton to teach.
        agent: name of the agent to teach.
        budget: maximum number of examples, including default ones, or None for no limit.
    """

    name: str
    file: Path
    agent: str
    steps: tuple[Step, ...]
    budget: int | None = None
    description: str = ""


class _File(Record):
    format: Format = 1
    lesson: str
    agent: str
    budget: int | None = Field(default=None, ge=1)
    description: str = ""
    steps: list[Annotated[Step, OneOf(Step.kinds)]] = Field(min_length=1)


def read_lesson(path: Path) -> Lesson:
    """Read a lesson.

    Raises:
        LessonError: if the lesson is invalid; names all faults by file and line.
    """
    return parse_lesson(read_text(path, error=LessonError), path)


def parse_lesson(text: str, path: Path) -> Lesson:
    """Read a lesson from its text; errors name ``path``."""
    document = read_yaml(text, str(path), error=LessonError)
    read = open_record(_File, document, LESSON_FORMAT)
    steps = tuple(
        _completed(step, document.line(("steps", index)), step.agent or read.agent)
        for index, step in enumerate(read.steps)
    )
    return Lesson(read.lesson, path, read.agent, steps, read.budget, read.description)


def _completed(step: Step, line: int, agent: str) -> Step:
    """Return a step with its line, and with the default agent where it names none."""
    more: dict[str, Any] = {"line": line, "agent": agent}
    match step:
        case Wait():
            more |= {"condition": Passed(seconds=step.seconds), "within": step.seconds + 1.0}
            return Until.model_construct(**more)
        case Until():
            more["condition"] = step.condition.about(agent)
        case Perform(agents=()):
            more["agents"] = (agent,)
    return step.but(**more)
