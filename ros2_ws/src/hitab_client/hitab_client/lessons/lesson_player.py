"""Player of lessons, which acts as a demonstrator through the public topics and services.

A simulated world is stepped cycle by cycle, as fast as the agents answer, and every condition is
checked in every cycle, so that a lesson always gives the same examples. Robots without a world are
watched in real time.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from hitab_msgs.srv import Control

from hitab_client.errors import LessonError, SwarmError
from hitab_client.lessons.condition_watch import ConditionWatch
from hitab_client.lessons.lesson import (
    Check,
    Lesson,
    Never,
    NewEpisode,
    Operate,
    Place,
    Say,
    Step,
    Until,
)
from hitab_client.showing.world_as_it_was import standing_still
from hitab_client.swarm_client import SwarmClient
from hitab_client.terminal.interruptions import not_interrupted
from hitab_client.world_client import WorldClient
from hitab_core import ExampleKind, HitabError, quantity, some
from hitab_core.operations import (
    BeginTraining,
    Command,
    DiscardTraining,
    Distribute,
    Perform,
    SaveBehavior,
)
from hitab_core.training.operation import Operation


@dataclass
class LessonReport:
    """The cost and outcome of a lesson.

    Attributes:
        examples: number of examples of the saved automaton, including default ones.
        commands: number of the demonstrator's commands.
        simulated_s: training time as the robots see it, s.
        wall_s: elapsed wall time, s.
        digest: digest of the saved file.
        note: the message of the save, such as which version it replaces.
    """

    lesson: str
    budget: int | None = None
    examples: int = 0
    default_examples: int = 0
    commands: int = 0
    simulated_s: float = 0.0
    wall_s: float = 0.0
    digest: str = ""
    path: str = ""
    note: str = ""
    trimmed: list[str] = field(default_factory=list)
    checks: list[str] = field(default_factory=list)


Progress = Callable[[int, int, str], None]
"""Called with the number of the step, the number of steps and the current activity."""


class LessonPlayer:
    """Plays one lesson.

    Args:
        lesson: the lesson.
        swarm: client of the agents.
        world: client of the world, which the lesson drives; None without a world, as with
            real robots.
        factor: multiple of real time, for watching a world; 0 for full speed.
        discard: whether to discard an agent's unsaved training before the lesson.

    Attributes:
        report: the cost and outcome so far.
        begun: automata in training that the lesson has begun and not saved yet, by agent.
        watch: evaluates the lesson's conditions, and steps the world if there is one.
    """

    def __init__(
        self,
        lesson: Lesson,
        swarm: SwarmClient,
        world: WorldClient | None,
        *,
        factor: float = 0.0,
        discard: bool = False,
    ) -> None:
        self.lesson = lesson
        self.swarm = swarm
        self.world = world
        self.report = LessonReport(lesson.name, lesson.budget)
        self.begun: dict[str, str] = {}
        self.watch = ConditionWatch(swarm, world, factor=factor)
        self._discard = discard
        self._performing: dict[str, str] = {}

    def play(self, progress: Progress | None = None) -> LessonReport:
        """Play all steps, then restore the pace and mode of the world, if there is one.

        Args:
            progress: called before every step.

        Raises:
            LessonError: if a step is refused or fails, or the lesson exceeds its budget of
                examples; names the lesson's file and line.
        """
        began = time.monotonic()
        with standing_still(self.world):
            start = self.watch.now()
            with self.watch:
                for index, step in enumerate(self.lesson.steps):
                    if progress is not None:
                        progress(index, len(self.lesson.steps), _described(step))
                    self._play(step)
            self.report.simulated_s = round(self.watch.now() - start, 3)
        self.report.wall_s = round(time.monotonic() - began, 3)
        self._check_budget()
        return self.report

    def take_back(self) -> list[str]:
        """Discard the lesson's unsaved trainings; return sentences about the outcome."""
        outcomes = []
        with not_interrupted():
            for agent, automaton in self.begun.items():
                try:
                    outcomes.append(self.swarm.do(agent, DiscardTraining()).message)
                except SwarmError as error:
                    outcomes.append(f'{agent} may still be training "{automaton}": {error}')
            self.begun.clear()
        for behavior in filter(None, dict.fromkeys(self._performing.values())):
            agents = [agent for agent, its in self._performing.items() if its == behavior]
            verb = "goes" if len(agents) == 1 else "go"
            outcomes.append(f"{some(agents)} {verb} on performing {behavior}")
        return outcomes

    def _play(self, step: Step) -> None:
        self.watch.begin()
        try:
            if isinstance(step, Operate):
                self._operate(step)
            else:
                getattr(self, f"_{step.kind}")(step)
        except HitabError as error:
            place = f"{self.lesson.file}:{step.line}: step `{step.kind}`"
            raise LessonError(error.problem, *error.remedies, where=place) from None

    # -- the steps --------------------------------------------------------------------------

    def _arranged(self) -> WorldClient:
        """Return the world, in which things can be placed.

        Raises:
            LessonError: if there is no world.
        """
        if self.world is None:
            raise LessonError(
                "there is no simulated world in which to put things; have the robot drive there "
                "with `perform:` and `until:`"
            )
        return self.world

    def _place(self, step: Place) -> None:
        world = self._arranged()
        world.shown(world.place(step.things, new_episode=step.new_episode))

    def _new_episode(self, step: NewEpisode) -> None:
        world = self._arranged()
        world.shown(world.control(Control.Request.RESET))

    def _told_now(self, step: Until) -> str:
        return step.condition.describe(self.watch.view())

    def _until(self, step: Until) -> None:
        if not self.watch.until(step.condition, step.within):
            raise LessonError(f"waited {step.within:g} s in vain until {self._told_now(step)}")

    def _check(self, step: Check) -> None:
        if not self.watch.until(step.condition, step.within):
            raise LessonError(
                f"what was learned fails this check, within {step.within:g} s: "
                f"{self._told_now(step)}; teach more examples before this"
            )
        self.report.checks.append(
            f"{step.condition.describe()} after {self.watch.view().seconds:.1f} s"
        )

    def _never(self, step: Never) -> None:
        if self.watch.until(step.condition, step.within):
            raise LessonError(
                f"this should not happen, but did after {self.watch.view().seconds:.1f} s: "
                f"{self._told_now(step)}"
            )
        self.report.checks.append(f"never {step.condition.describe()} in {step.within:g} s")

    def _operate(self, step: Operate) -> None:
        for agent in step.agents:
            operation = step.operation
            if isinstance(operation, Distribute):
                if missing := self.swarm.distribute(agent, operation).missing:
                    raise LessonError("; ".join(f"{name} {why}" for name, why in missing.items()))
                continue
            if isinstance(operation, BeginTraining):
                discard = self._discard and agent not in self.begun
                operation = replace(operation, discard=discard)
            # An interruption must not hide what an agent was made to do.
            with not_interrupted():
                answer = self.swarm.do(agent, operation, world=self.world)
                self._note(agent, operation, answer)

    def _note(self, agent: str, operation: Operation, answer: Any) -> None:
        """Note what an operation has changed: for the report, and for taking it back."""
        match operation:
            case BeginTraining():
                self.begun[agent] = operation.automaton
            case Command():
                self.report.commands += 1
            case Perform():
                self._performing[agent] = operation.behavior
            case DiscardTraining():
                self.begun.pop(agent, None)
            case SaveBehavior():
                self.begun.pop(agent, None)
                name = operation.automaton or self.lesson.name
                examples = self.swarm.behavior(agent, name).examples
                self.report.examples = len(examples)
                self.report.default_examples = sum(e.kind is ExampleKind.DEFAULT for e in examples)
                self.report.digest = answer.digest
                self.report.path = answer.path
                self.report.note = answer.replaced
                self.report.trimmed = list(answer.trimmed)

    def _say(self, step: Say) -> None:
        """Do nothing: the progress report has shown the text."""

    def _check_budget(self) -> None:
        budget, examples = self.lesson.budget, self.report.examples
        if budget is not None and examples > budget:
            raise LessonError(
                f"{self.lesson.file}: took {quantity(examples, 'example')}, including "
                f"default ones, but its budget is {budget}; give fewer commands, or raise "
                "`budget:`"
            )


def _described(step: Step) -> str:
    """Return a short description of a step."""
    kind = step.kind.replace("_", " ")
    match step:
        case Say():
            return step.text
        case Until():
            return f"{kind} {step.condition.describe()}"
        case Operate():
            given = str(getattr(step, step.first)) if step.first else ""
            return f"{some(step.agents)}: {kind} {given}".rstrip()
    return kind
