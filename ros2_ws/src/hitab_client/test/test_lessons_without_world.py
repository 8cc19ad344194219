"""Lessons of robots that have no simulated world."""

import math
from pathlib import Path
from types import SimpleNamespace

import pytest
from hitab_msgs.msg import Reading

from hitab_client.errors import LessonError
from hitab_client.lessons.condition_watch import ConditionWatch
from hitab_client.lessons.lesson import parse_lesson
from hitab_client.lessons.lesson_player import LessonPlayer

LESSON = """\
lesson: Wander
agent: robot_1
steps:
  - {step}
"""


@pytest.mark.parametrize("step", ["place: {ball: {x: 1}}", "new_episode: true"])
def test_that_nothing_can_be_put_somewhere_is_told_by_file_and_line(step):
    lesson = parse_lesson(LESSON.format(step=step), Path("wander.yaml"))
    player = LessonPlayer(lesson, SimpleNamespace(statuses={}), None)
    refused = pytest.raises(LessonError, match=r"wander\.yaml:4: .* no simulated world")
    with refused:
        player._play(lesson.steps[0])


@pytest.mark.parametrize(
    ("automata", "values", "expected"),
    [
        # A flag has a value only as a feature of an automaton: the outermost one that uses it.
        (["Patrol", "GoTo(A)", ""], [1.0, 0.0, math.nan], 1.0),
        ([""], [0.5], 0.5),
    ],
)
def test_a_flag_is_read_as_the_automaton_sees_it(automata, values, expected):
    read = zip(automata, values, strict=True)
    readings = [Reading(automaton=a, feature="Done", value=value) for a, value in read]
    answer = SimpleNamespace(readings=readings)
    swarm = SimpleNamespace(statuses={"robot_1": None}, read_features=lambda *_, **__: answer)
    assert ConditionWatch(swarm)._reading("robot_1", "Done") == expected
