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
follow `until`, `check` and `never`; every class below is a kind of step, and so is every operation
of `hitab_core.operations`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import MISSING, dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import Field, PlainValidator, create_model

from hitab_client.errors import LessonError
from hitab_client.lessons.conditions import Condition, Passed
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
from hitab_core.operations import MOMENT, OPERATIONS
from hitab_core.training.operation import Operation, is_required

LESSON_FORMAT = 3
"""The newest format version that is read; 2 has the condition `feature`, 3 all operations."""

WITHIN = 20.0
"""Default simulated seconds within which an awaited condition must hold."""


def _use(value: Any) -> str:
    return str(read_use(str(value)))


def _use_or_nothing(value: Any) -> str:
    return "" if value == "nothing" else _use(value)


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
        if cls.kind in cls.known():
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


class NewEpisode(Step):
    """Begin a new episode with all agents in Start."""

    new_episode: Any


class Operate(Step):
    """Have agents carry out an operation; `operate` makes a kind of this step for each.

    Attributes:
        does: type of the operation.
        first: the operation's field that the first key gives; else the key is followed by `true`.
        agents: names of the agents; by default, that of the step.
    """

    does: ClassVar[type[Operation]]
    first: ClassVar[str]
    agents: Texts = ()

    @property
    def operation(self) -> Operation:
        """The operation."""
        given = self.does.own_fields().keys() & type(self).model_fields.keys()
        return self.does(**{name: getattr(self, name) for name in given})


_OBJECT = re.compile("_(training|examples|question|behavior)$")
"""End of an operation's name that its key in lessons does not have."""

_KEYS = {"automaton": "name", "bindings": "bind"}
"""Keys in lessons for fields of operations that do not have their names."""

_UNWRITTEN = MOMENT | {"discard"}
"""Fields of operations that lessons do not set: the player discards, and acts without delay."""

_SIMPLE = {"bool": bool, "int": int, "float": float, "str": str}
_LISTS = {"Sequence[int]": list[int], "Sequence[str]": Texts, "Mapping[str, str]": Names}
_TYPES: dict[str, Any] = {**_SIMPLE, **_LISTS}
"""Types of values in lessons, by types of operations' fields."""


def operate(does: type[Operation]) -> None:
    """Make the kind of step for an operation, with a key for each field.

    The first key gives the behavior, or the first field if that is required.
    """
    key, first, keys = _OBJECT.sub("", does.name), "", dict[str, Any]()
    for name, field in does.own_fields().items():
        if name in _UNWRITTEN:
            continue
        kind, default = _TYPES[str(field.type)], field.default
        if name in ("behavior", "next_state"):
            kind = Annotated[str, PlainValidator(_use if is_required(field) else _use_or_nothing)]
        if name == "behavior" or (not keys and is_required(field)):
            first = name
        if default is MISSING:
            default = ... if is_required(field) else {}
        keys[name] = kind, Field(default, alias=key if name == first else _KEYS.get(name))
    if not first:
        keys[key] = Any, ...
    step: Any = create_model(key, __base__=Operate, __doc__=does.__doc__, **keys)
    step.does, step.first = does, first


for _operation in OPERATIONS.values():
    operate(_operation)


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
        case Operate(agents=()):
            more["agents"] = (agent,)
    return step.but(**more)
