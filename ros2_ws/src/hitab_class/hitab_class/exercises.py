"""The exercises of a class: requirements on a student's library and episodes, and their grading.

exercise: Chase
description: Train a keeper that runs after the ball.
swarm: keepaway
agent: keeper_1
requires:
  - behavior: Chase
    examples: 20                        # at most
  - decides: Chase
    state: GoFast
    seeing: {DirectionTo(ball): 170}    # degrees; `yes` and `no` for what is true or not
    go_to: TurnToBall
  - reaches: {distance: [keeper_1, ball], below: 1.2}
    performing: Chase
    within: 20                          # s
    in: 8                               # at least, of so many episodes:
    of: 10
  - shared: Chase
    agents: [keeper_2, keeper_3]
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import Field

from hitab_bringup import (
    games_of,
    holds_behaviors,
    in_words,
    open_library,
    part_of,
    read_swarm,
    value_of,
)
from hitab_client import LessonError, WorldView
from hitab_client.lessons import Condition
from hitab_client.runs.shipped import find_file
from hitab_client.terminal.cli_remedies import called
from hitab_core import BehaviorLibrary, ExampleKind, HitabError, has, quantity
from hitab_core.library import BehaviorFile, Expectation
from hitab_core.library.yaml_models import Format, OneOf, Record, Texts, open_record
from hitab_core.library.yaml_places import read_text, read_yaml
from hitab_world.inprocess import play

FORMAT = 1
SEED = 2026


class Student:
    """The libraries of a student's agents.

    Args:
        swarm: name of the student's swarm, for messages.
        libraries: the libraries of the swarm's agents, by name.
    """

    def __init__(self, swarm: str, libraries: Mapping[str, Path]) -> None:
        self.swarm = swarm
        self.libraries = libraries

    def library(self, agent: str) -> BehaviorLibrary | None:
        """Return the library of an agent; None if nothing is saved in it."""
        folder = self.libraries.get(agent)
        return open_library(folder) if folder is not None and holds_behaviors(folder) else None

    def file(self, agent: str, behavior: str) -> BehaviorFile:
        """Return a behavior of an agent.

        Raises:
            HitabError: naming the missing library or behavior.
        """
        library = self.library(agent)
        if agent not in self.libraries:
            raise HitabError(f"swarm {self.swarm} was not up yet with {agent}; start it")
        if library is None:
            raise HitabError(f"nothing is saved for {agent} yet; train {behavior} and save it")
        library.load(strict=False)
        if behavior in library.problems:
            raise HitabError(library.problems[behavior])
        if behavior not in library.files:
            raise HitabError(
                f'{agent} has saved no "{behavior}" {has(library.files, behavior)}; train and '
                "save it"
            )
        return library.files[behavior]


class BehaviorSaved(Record):
    """The requirement that a behavior is saved."""

    behavior: str
    examples: int = 10**6
    corrections: int = 0
    expectations: int = 0

    def in_words(self, exercise: Exercise, student: Student) -> str:
        """Return the requirement in words."""
        counts = [
            f"at most {quantity(self.examples, 'example')}" if self.examples < 10**6 else "",
            quantity(self.corrections, "correction") if self.corrections else "",
            quantity(self.expectations, "expectation") if self.expectations else "",
        ]
        counted = [count for count in counts if count]
        with_ = f" with {', '.join(counted)}" if counted else ""
        return f"{exercise.agent} has saved {self.behavior}{with_}"

    def missing(self, exercise: Exercise, student: Student) -> str:
        """Return the unmet part of the requirement."""
        file = student.file(exercise.agent, self.behavior)
        examples = file.automaton.examples
        corrections = sum(example.kind is ExampleKind.CORRECTION for example in examples)
        if len(examples) > self.examples:
            return f"it has {len(examples)} examples; show less, in clearer situations"
        if corrections < self.corrections:
            return (
                f"it has {quantity(corrections, 'correction')}; resume its training, test it, "
                "take over where it is wrong, and command the right behavior"
            )
        if len(file.expectations) < self.expectations:
            return f"it carries too few; add some with `{called()} library expect`"
        return "; ".join(file.broken)


class BehaviorDecides(Record):
    """The requirement that a behavior decides for a state in a situation."""

    behavior: str = Field(alias="decides")
    state: str
    go_to: str
    seeing: dict[str, Any] = Field(default_factory=dict)

    def _expected(self, library: BehaviorLibrary) -> Expectation:
        seen = {f: value_of(str(v), f, library.domain) for f, v in self.seeing.items()}
        return Expectation(self.behavior, self.state, seen, self.go_to)

    def in_words(self, exercise: Exercise, student: Student) -> str:
        """Return the requirement in words."""
        library = student.library(exercise.agent)
        if library is None:
            return f"{self.behavior} goes from {self.state} to {self.go_to} where it should"
        return in_words(self._expected(library), library.domain).removeprefix("expects ")

    def missing(self, exercise: Exercise, student: Student) -> str:
        """Return the unmet part of the requirement."""
        file = student.file(exercise.agent, self.behavior)
        library = student.library(exercise.agent)
        assert library is not None
        broken = self._expected(library).broken(file.automaton).partition(": ")[2]
        return f"{broken}; arrange this situation and command {self.go_to}" if broken else ""


class BehaviorShared(Record):
    """The requirement that other agents have the same behavior."""

    behavior: str = Field(alias="shared")
    agents: Texts

    def in_words(self, exercise: Exercise, student: Student) -> str:
        """Return the requirement in words."""
        return f"{', '.join(self.agents)} have the {self.behavior} of {exercise.agent}"

    def missing(self, exercise: Exercise, student: Student) -> str:
        """Return the unmet part of the requirement."""
        mine = student.file(exercise.agent, self.behavior).learned
        other = [a for a in self.agents if student.file(a, self.behavior).learned != mine]
        return f"{', '.join(other)} learned otherwise; distribute it again" if other else ""


class ConditionReached(Record):
    """The requirement that a condition comes to hold in episodes where only the agent acts."""

    condition: Condition = Field(alias="reaches")
    performing: str
    within: float = Field(gt=0.0)
    at_least: int = Field(alias="in", ge=1)
    of: int = Field(ge=1)

    def in_words(self, exercise: Exercise, student: Student) -> str:
        """Return the requirement in words."""
        return (
            f"performing {self.performing}, {self.condition.describe()} within {self.within:g} s "
            f"in {self.at_least} of {quantity(self.of, 'episode')}"
        )

    def missing(self, exercise: Exercise, student: Student) -> str:
        """Play the episodes, and return the unmet part of the requirement."""
        student.file(exercise.agent, self.performing)
        swarm = read_swarm(find_file(exercise.swarm, "swarms", "swarm")).with_world(seed=SEED)
        part = part_of(student.libraries[exercise.agent], self.performing)
        reached: set[int] = set()
        with games_of(swarm, [{exercise.agent: part}]) as ((world, players, _),):

            def look() -> None:
                things: Any = world.entities()
                if self.condition.holds(WorldView(things)):
                    reached.add(world.episode)

            cycles = round(self.within / world.cycle_seconds)
            play(world, players, self.of, between=look, cycles_max=cycles, first=0)
        if len(reached) >= self.at_least:
            return ""
        failed = next(number for number in range(self.of) if number not in reached)
        return f"it does in {len(reached)}, and not in episode {failed}; watch it, and correct it"


REQUIREMENTS = {
    "behavior": BehaviorSaved,
    "decides": BehaviorDecides,
    "shared": BehaviorShared,
    "reaches": ConditionReached,
}
Requirement = BehaviorSaved | BehaviorDecides | BehaviorShared | ConditionReached
"""A requirement of an exercise: `in_words` describes it, `missing` returns its unmet part or "".

`missing` raises `HitabError` if the requirement cannot be checked; the error names the reason.
"""


class Exercise(Record):
    """An exercise, as in its file."""

    format: Format = FORMAT
    exercise: str
    description: str
    swarm: str
    agent: str
    requires: list[Annotated[Requirement, OneOf(REQUIREMENTS)]] = Field(min_length=1)

    @property
    def agents(self) -> list[str]:
        """The agents of the exercise."""
        others = [name for one in self.requires for name in getattr(one, "agents", ())]
        return [self.agent, *others]

    def grade(self, student: Student) -> list[Grade]:
        """Return a grade for each requirement."""
        grades = []
        for one in self.requires:
            words = one.in_words(self, student)
            try:
                grades.append(Grade(words, one.missing(self, student)))
            except HitabError as error:
                grades.append(Grade(words, str(error)))
        return grades


class Grade(NamedTuple):
    """The grade for a requirement: whether it is met.

    Attributes:
        requirement: the requirement in words.
        missing: the unmet part; "" if there is none.
    """

    requirement: str
    missing: str


def read_exercise(path: Path) -> Exercise:
    """Read an exercise.

    Raises:
        LessonError: naming all errors, by file and line.
    """
    document = read_yaml(read_text(path, error=LessonError), str(path), error=LessonError)
    return open_record(Exercise, document, FORMAT)
