"""Lesson files: their format, and errors with file and line."""

import math
from pathlib import Path

import pytest

from hitab_client.errors import LessonError
from hitab_client.lessons.conditions import ActiveState, Distance, Passed
from hitab_client.lessons.lesson import Until, parse_lesson, read_lesson
from hitab_client.runs.shipped import find_file
from hitab_core.operations import (
    BeginTraining,
    Command,
    Distribute,
    Perform,
    RelabelExamples,
    SaveBehavior,
    SetCaution,
    Test,
    Undo,
)

HERE = Path("lessons/dance.yaml")
HEAD = "lesson: Dance\nagent: keeper_1\nsteps:\n"


def steps(text: str):
    return parse_lesson(HEAD + text, HERE).steps


def complaint(text: str) -> str:
    with pytest.raises(LessonError) as error:
        parse_lesson(text, HERE)
    return str(error.value)


def test_a_lesson_is_read_step_by_step():
    read = steps(
        "  - place: {ball: {x: 1, heading: 90}}\n    new_episode: true\n"
        "  - begin: Dance\n    features: [DistanceTo(A)]\n    parameters: {A: ball}\n"
        "  - command: GoTo(A)\n"
        "  - until: {distance: [keeper_1, ball], below: 4}\n    within: 3\n"
        "  - wait: 1.5\n"
        "  - test: true\n    restart: true\n"
        "  - save: true\n    bind: {ball: A}\n"
        "  - distribute: Dance\n    receivers: [keeper_2]\n    start: true\n"
        "  - perform: nothing\n    agents: [keeper_2, keeper_3]\n"
    )
    place, begin, command, until, wait, test, save, distribute, perform = read
    assert place.things == {"ball": {"x": 1.0, "heading": math.radians(90)}}
    assert place.new_episode
    assert begin.operation == BeginTraining("Dance", ("DistanceTo(A)",), parameters={"A": "ball"})
    assert (command.line, command.agent, command.agents) == (9, "keeper_1", ("keeper_1",))
    assert command.operation == Command("GoTo(A)")
    assert until.condition == Distance(distance=["keeper_1", "ball"], below=4.0)
    assert until.within == 3.0
    assert isinstance(wait, Until)
    assert wait.condition == Passed(seconds=1.5)
    assert (test.line, test.agent, test.operation) == (13, "keeper_1", Test(restart=True))
    assert save.operation == SaveBehavior(bindings={"ball": "A"})
    assert (distribute.line, distribute.agent) == (17, "keeper_1")
    assert distribute.operation == Distribute("Dance", receivers=("keeper_2",), start=True)
    assert (perform.line, perform.agent) == (20, "keeper_1")
    assert (perform.operation, perform.agents) == (Perform(), ("keeper_2", "keeper_3"))


def test_every_operation_is_a_step_with_the_keys_of_its_fields():
    undo, relabel, caution = steps(
        "  - undo: true\n    agents: [keeper_1, keeper_2]\n"
        "  - relabel: [3, 4]\n    next_state: GoTo(ball)\n"
        "  - set_caution: halt\n    distance: 3\n"
    )
    assert (undo.operation, undo.agents) == (Undo(), ("keeper_1", "keeper_2"))
    assert relabel.operation == RelabelExamples([3, 4], "GoTo(ball)")
    assert caution.operation == SetCaution("halt", 3.0)


def test_conditions_mean_the_learner_where_no_agent_is_named():
    (step,) = steps("  - check: {all: [{active: Pass}, {active: Stop, agent: keeper_2}]}\n")
    assert step.condition.parts == [
        ActiveState(active="Pass", agent="keeper_1"),
        ActiveState(active="Stop", agent="keeper_2"),
    ]


@pytest.mark.parametrize("name", ["approach_ball", "goto_ball", "control_ball", "keepaway"])
def test_the_shipped_lessons_keep_to_the_papers_budgets(name):
    budgets = {"ApproachBall": 18, "GotoBall": 10, "ControlBall": 11, "Keepaway": 10}
    lesson = read_lesson(find_file(name, "lessons", "lesson"))
    assert lesson.budget is not None
    assert 0 < lesson.budget <= budgets[lesson.name]
    assert "command" in [step.kind for step in lesson.steps]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (HEAD + "  - comand: Stop\n", 'Did you mean "command"?'),
        (
            HEAD + "  - command: Stop\n    say: hi\n",
            "4: item 1 of `steps:` needs exactly one kind",
        ),
        (
            HEAD + "  - say: hi\n  - command: Go(to\n",
            '5: `command:` "Go(to" is not a use of a behavior',
        ),
        (HEAD + "  - delete: 3\n", "4: `delete:` must be a list, not 3"),
        (HEAD + "  - relabel: [3]\n", "4: `next_state:` is missing here"),
        (HEAD + "  - undo: true\n    features: []\n", "5: `features:` is not known here"),
        (HEAD + "  - until: {distance: [a], below: 1}\n", "needs 2 things, such as [keeper_1"),
        (HEAD + "  - until: {distance: [a, b]}\n", "4: `until:` needs `below:` or `above:`"),
        (HEAD + "  - until: {far: 1}\n", "4: `until:` has no known kind (known: feature, bearing"),
    ],
)
def test_everything_wrong_is_told_with_its_place(text, expected):
    assert expected in complaint(text)
