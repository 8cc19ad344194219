"""Reads lessons from their YAML files; `lesson` shows what they look like."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hitab_client.errors import LessonError
from hitab_client.lessons.conditions import Passed, parse_condition
from hitab_client.lessons.lesson import (
    WITHIN,
    Begin,
    Check,
    Command,
    Distribute,
    Lesson,
    Never,
    NewEpisode,
    Perform,
    Place,
    Save,
    Say,
    Step,
    TakeOver,
    Test,
    Undo,
    Until,
)
from hitab_core import HitabError, Use, has
from hitab_core.library import Fields
from hitab_core.library.yaml_places import Complaints, read_text, read_yaml

FORMAT = 2
"""The newest format version that is read; 2 has the condition `feature`."""


def read_lesson(path: Path) -> Lesson:
    """Read a lesson.

    Raises:
        LessonError: naming everything that is wrong, by file and line.
    """
    return parse_lesson(read_text(path, error=LessonError), path)


def parse_lesson(text: str, path: Path) -> Lesson:
    """Read a lesson from its text; ``path`` is its name for errors."""
    top = Fields(Complaints(read_yaml(text, str(path), error=LessonError), LessonError))
    top.check_format(FORMAT)
    name = top.text("lesson") or ""
    agent = top.text("agent") or ""
    budget = top.integer("budget", None, least=1)
    description = top.text("description", "")
    steps = [_step(fields, agent) for fields in top.each("steps")]
    if not steps:
        top.complain("a lesson needs `steps:`, a list of steps")
    top.done()
    top.complaints.raise_any()
    return Lesson(name, path, agent, tuple(s for s in steps if s is not None), budget, description)


def _step(fields: Fields, agent: str) -> Step | None:
    kinds = [kind for kind in STEPS if kind in fields]
    if "place" in kinds and "new_episode" in kinds:
        kinds.remove("new_episode")  # here it is an option of `place`
    if len(kinds) != 1:
        keys = fields.names()
        told = "needs exactly one kind" if kinds else "has no known kind"
        fields.complain(f"a step {told} {has(STEPS, *keys)}")
        return None
    step = STEPS[kinds[0]](fields, fields.line, fields.text("agent", agent))
    fields.done()
    return step


def _use(fields: Fields, key: str) -> Use:
    text = fields.text(key) or "missing"
    try:
        return Use.parse(text)
    except HitabError as error:
        fields.complain(str(error), key)
        return Use("missing")


def _say(fields: Fields, line: int, agent: str) -> Step:
    return Say(line, agent, fields.text("say") or "")


def _place(fields: Fields, line: int, agent: str) -> Step:
    things = placed_things(fields.inner("place"))
    return Place(line, agent, things, fields.flag("new_episode", False))


def placed_things(group: Fields) -> dict[str, dict[str, float]]:
    """Read where things are put: x, y, heading (in the file in degrees), vx, vy by name."""
    things: dict[str, dict[str, float]] = {}
    for name in group.names():
        thing = group.inner(name)
        place = {key: thing.number(key, None) for key in ("x", "y", "heading", "vx", "vy")}
        thing.done()
        known = {key: value for key, value in place.items() if value is not None}
        if "heading" in known:
            known["heading"] = math.radians(known["heading"])
        things[name] = known
    return things


def _begin(fields: Fields, line: int, agent: str) -> Step:
    bound = fields.inner("parameters")
    return Begin(
        line,
        agent,
        fields.text("begin") or "",
        fields.texts("features", ()),
        fields.texts("states", ()),
        {name: bound.text(name) or "" for name in bound.names()},
        fields.text("resume", ""),
        fields.text("classifier", ""),
    )


def _command(fields: Fields, line: int, agent: str) -> Step:
    return Command(line, agent, _use(fields, "command"))


def _awaiting(kind: Any) -> Callable[[Fields, int, str], Step]:
    def parse(fields: Fields, line: int, agent: str) -> Step:
        condition = parse_condition(fields.inner(kind.kind), agent)
        within = fields.number("within", WITHIN, above=0.0)
        step: Step = kind(line, agent, condition, within)
        return step

    return parse


def _wait(fields: Fields, line: int, agent: str) -> Step:
    seconds = fields.number("wait", above=0.0) or 0.0
    return Until(line, agent, Passed(seconds), seconds + 1.0)


def _test(fields: Fields, line: int, agent: str) -> Step:
    fields.raw("test")
    return Test(line, agent, fields.flag("restart", False))


def _save(fields: Fields, line: int, agent: str) -> Step:
    fields.raw("save")
    bind = fields.inner("bind")
    return Save(
        line,
        agent,
        fields.text("name", ""),
        {name: bind.text(name) or "" for name in bind.names()},
        fields.text("description", ""),
        fields.flag("keep_unused", False),
    )


def _distribute(fields: Fields, line: int, agent: str) -> Step:
    return Distribute(
        line,
        agent,
        _use(fields, "distribute"),
        fields.texts("receivers", ()),
        fields.flag("start", False),
    )


def _perform(fields: Fields, line: int, agent: str) -> Step:
    use = _use(fields, "perform")
    return Perform(
        line, agent, None if use.name == "nothing" else use, fields.texts("agents", (agent,))
    )


def _bare(kind: Any) -> Callable[[Fields, int, str], Step]:
    def parse(fields: Fields, line: int, agent: str) -> Step:
        fields.raw(kind.kind)
        step: Step = kind(line, agent)
        return step

    return parse


STEPS: dict[str, Callable[[Fields, int, str], Step]] = {
    "say": _say,
    "place": _place,
    "begin": _begin,
    "command": _command,
    "until": _awaiting(Until),
    "check": _awaiting(Check),
    "never": _awaiting(Never),
    "wait": _wait,
    "test": _test,
    "take_over": _bare(TakeOver),
    "undo": _bare(Undo),
    "save": _save,
    "distribute": _distribute,
    "perform": _perform,
    "new_episode": _bare(NewEpisode),
}
