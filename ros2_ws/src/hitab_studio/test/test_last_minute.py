"""The last minute is remembered: what agents did, with marks, and the field."""

from dataclasses import replace

import numpy as np
from hitab_msgs.msg import AgentStatus

from hitab_studio.field.last_minute import Minute, glimpse_at, marks
from hitab_studio.field.scene import Scene

EMPTY = Scene((20.0, 20.0), (), (), (), np.zeros((0, 5)), {})


def seen(cycles: range, episode: int = 1) -> Minute:
    minute = Minute()
    for cycle in cycles:
        minute.see(replace(EMPTY, cycle=cycle, seconds=0.1 * cycle, episode=episode), cycle)
    return minute


def status(state: str, **training: object) -> AgentStatus:
    made = AgentStatus(mode="training", active_path=[state])
    for name, value in training.items():
        setattr(made.training, name, value)
    return made


def test_commands_questions_unsure_moments_and_holds_are_marked():
    minute = seen(range(11))
    minute.hear("one", status("Start"), 1)
    minute.hear("one", status("Go", examples=2, demonstrator="Ada"), 3)
    unsure = status("Go", examples=2, demonstrator="Ada", questions=1)
    unsure.preview.unsure, unsure.held = "far from all", "one: Go"
    minute.hear("one", unsure, 7)
    found = [(mark.at, mark.kind) for mark in marks(minute.glimpses("one"))]
    assert found == [(3, "command"), (7, "question"), (7, "unsure"), (7, "held")]
    assert [*minute.eventful] == ["one"]
    assert minute.doing(2.0) == {"one": ("training", "Start")}
    assert minute.doing(0.0) == {}


def test_nothing_is_remembered_twice_or_without_bound():
    minute = seen(range(2))
    for cycle in range(2000):
        minute.hear("one", status("Go"), cycle)
    assert [g.at for g in minute.glimpses("one")] == [0]
    for cycle in range(2000):
        minute.hear("two", status(f"Go{cycle}"), cycle, agents=1000)
    assert len(minute.glimpses("two")) == 60


def test_what_came_after_is_forgotten_when_the_world_goes_back():
    minute = seen(range(101))
    for cycle, state in ((10, "A"), (60, "B")):
        minute.hear("one", status(state), cycle)
    minute.see(replace(EMPTY, cycle=40, seconds=4.0, episode=1), 40)
    assert [g.path for g in minute.glimpses("one")] == [("A",)]
    assert minute.scenes.moments[-1] == minute.now == 40
    assert minute.rate > 9.9
    assert glimpse_at(minute.glimpses("one"), 99).state == "A"


def test_only_a_minute_is_offered_and_the_nearest_scene_before_is_shown():
    minute = seen(range(0, 1000, 3))
    assert minute.begin == minute.now - 600 * minute.rate / 10
    assert minute.scenes.at(500.0)[0] == 498
    assert minute.scenes.at(498, -1)[0] == 495


def test_a_robots_own_cycle_is_interpolated():
    minute = Minute()
    assert minute.cycle("robot", 5.0, real=True) == 0
    for at, cycle in ((10.0, 500), (10.2, 510)):
        minute.hear_cycle("robot", cycle, at)
    assert minute.cycle("robot", 10.1, real=True) == 505
    assert minute.cycle("keeper", 17.0, real=False) == 17
