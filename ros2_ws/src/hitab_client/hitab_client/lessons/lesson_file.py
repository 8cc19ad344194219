"""Reads lessons from their YAML files; `lesson` shows what they look like."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from hitab_client.errors import LessonError
from hitab_client.lessons.conditions import Passed
from hitab_client.lessons.lesson import (
    Lesson,
    Perform,
    Step,
    Until,
    Wait,
)
from hitab_core.library.yaml_models import Format, OneOf, Record, open_record
from hitab_core.library.yaml_places import read_text, read_yaml

FORMAT = 2
"""The newest format version that is read; 2 has the condition `feature`."""


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
        LessonError: naming everything that is wrong, by file and line.
    """
    return parse_lesson(read_text(path, error=LessonError), path)


def parse_lesson(text: str, path: Path) -> Lesson:
    """Read a lesson from its text; ``path`` is its name for errors."""
    document = read_yaml(text, str(path), error=LessonError)
    read = open_record(_File, document, FORMAT)
    steps = tuple(
        _completed(step, document.line(("steps", index)), step.agent or read.agent)
        for index, step in enumerate(read.steps)
    )
    return Lesson(read.lesson, path, read.agent, steps, read.budget, read.description)


def _completed(step: Step, line: int, agent: str) -> Step:
    """Return a step with its line, and the agent that it is about where it names none."""
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
