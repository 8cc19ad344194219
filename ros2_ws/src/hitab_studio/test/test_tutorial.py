"""The tutorial finds its step from the page, whatever state the swarm is in."""

import asyncio
import itertools
import math
from types import MappingProxyType, SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import AgentStatus, TrainingStatus, WorldStatus

from hitab_client import Training
from hitab_core import Example, Term
from hitab_core.example import ExampleKind
from hitab_studio.studio import Studio
from hitab_studio.swarm.agent_watch import AgentState
from hitab_studio.swarm.swarm_finder import SwarmTarget
from hitab_studio.swarm.swarm_state import SwarmState
from hitab_studio.tutorial.lessons import (
    DIRECTION,
    FEATURES,
    KICKABLE,
    LESSONS,
    Situation,
    taught,
)
from hitab_studio.tutorial.progress import present_step

ONE = "keeper_1"
UP = SwarmTarget(0, "keepaway", (ONE,), 1, folder="/keepaway", world=True)


def percept(lesson: Situation) -> tuple[float, float]:
    return (float(lesson.distance < 1.0), math.radians(lesson.bearing))


def training(*lessons: Situation, name: str = "FetchBall", **values: Any) -> Training:
    examples = tuple(
        Example("Start", percept(one), one.behavior, ExampleKind.DEMONSTRATED, i, i)
        for i, one in enumerate(lessons, 1)
    )
    features = tuple(map(Term.parse, FEATURES))
    return Training(name, (), features, {}, examples=examples, **values)


def step(known: SwarmState, monkeypatch: Any, learned: Training | None = None, **page: Any) -> str:
    async def made() -> str:
        shown = Studio(lambda: SwarmTarget(0)).open()
        shown.studio.known = known
        shown.agent = ONE if ONE in known.statuses else ""
        monkeypatch.setattr(shown.studio.link, "training", lambda agent: learned)
        for name, value in page.items():
            setattr(shown, name, value)
        return present_step(shown).name

    return asyncio.run(made())


def keeper(mode: str = "idle", world: Any = None, **status: Any) -> SwarmState:
    given = {"agent": ONE, "mode": mode, "domain": "keepaway", **status}
    return SwarmState(
        UP,
        world=world or WorldStatus(mode="paused"),
        statuses={ONE: AgentStatus(**given)},
        watched=MappingProxyType({ONE: AgentState()}),
    )


@pytest.mark.parametrize(
    ("known", "expected"),
    [
        (SwarmState(), "swarm"),
        (SwarmState(UP, statuses={ONE: AgentStatus(domain="keepaway")}), "keepers"),
        (keeper(domain="turtlebot"), "keepers"),
        (keeper(), "open"),
    ],
    ids=["no swarm", "no world", "robots", "a keeper"],
)
def test_the_tutorial_says_first_what_is_missing(known, expected, monkeypatch):
    assert step(known, monkeypatch) == expected


@pytest.mark.parametrize(
    ("learned", "expected"),
    [
        (training(name="Chase"), "other"),
        (training(), "arrange-0"),
        (training(*LESSONS[:1]), "arrange-1"),
        (training(*LESSONS[:2]), "slip"),
        (training(*LESSONS[:2], undone=("Stop",)), "arrange-2"),
        (training(LESSONS[0], LESSONS[6]), "mend"),
        (training(*LESSONS), "preview"),
    ],
)
def test_a_training_under_way_is_taken_up_at_the_step_that_it_has_reached(
    learned, expected, monkeypatch
):
    assert step(keeper("training"), monkeypatch, learned) == expected


def test_a_step_stays_until_the_training_of_the_status_has_arrived(monkeypatch):
    async def shown(known: SwarmState, learned: Training | None, **page: Any) -> list[str]:
        one = Studio(lambda: SwarmTarget(0)).open()
        one.agent, one.studio.known = ONE, keeper()
        steps = [present_step(one).name]
        one.studio.known = known
        monkeypatch.setattr(one.studio.link, "training", lambda agent: learned)
        for name, value in page.items():
            setattr(one, name, value)
        return [*steps, present_step(one).name]

    now = keeper("training", training=TrainingStatus(automaton="FetchBall", revision=3))
    for learned, page, expected in (
        (None, {}, "open"),
        (training(revision=2), {}, "open"),
        (training(revision=3), {"busy": 1}, "open"),
        (training(revision=3), {}, "arrange-0"),
    ):
        assert asyncio.run(shown(now, learned, **page)) == ["open", expected]


def test_a_ball_straight_behind_is_behind_on_either_side():
    assert all(LESSONS[0].fits({KICKABLE: 0.0, DIRECTION: at}) for at in (math.pi, -math.pi))


def test_a_recording_is_to_be_closed_first(monkeypatch):
    replay = SimpleNamespace(state=SwarmState())
    assert step(keeper(), monkeypatch, player=replay) == "live"


def test_a_moment_that_is_past_is_to_be_left_first(monkeypatch):
    assert step(keeper(), monkeypatch, time=SimpleNamespace(past=object())) == "now"
    assert step(keeper(), monkeypatch, time=SimpleNamespace(past=None)) == "open"


def test_a_situation_that_no_lesson_asks_for_does_not_count_and_is_to_be_undone():
    early = Situation("TurnToBall", "", bearing=20.0)  # the ball was not behind yet
    assert taught(training(early)) == (0, True)
    assert taught(training(LESSONS[0])) == (1, False)
    assert taught(training(*LESSONS, early)) == (len(LESSONS), False)


def test_no_two_lessons_in_a_row_are_the_same_situation():
    for one, other in itertools.pairwise(LESSONS):
        assert not one.fits(dict(zip(FEATURES, percept(other), strict=True)))
