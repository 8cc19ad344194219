"""Conditions of lessons hold when a person would say that they do."""

from dataclasses import dataclass

import pytest

from hitab_client.errors import LessonError
from hitab_client.lessons.conditions import (
    ActiveState,
    All,
    AnyOf,
    Bearing,
    Distance,
    Ended,
    FeatureValue,
    Not,
    Passed,
    Said,
    Speed,
)
from hitab_client.showing.world_view import WorldView


@dataclass
class Thing:
    name: str
    kind: str
    x: float
    y: float
    heading: float = 0.0
    vx: float = 0.0
    vy: float = 0.0
    say: str = ""


KEEPER = Thing("keeper_1", "keeper", 0.0, 0.0, heading=0.0, vx=3.0, vy=4.0)
BALL = Thing("ball", "ball", 0.0, 5.0)
NEAR = Thing("taker_1", "taker", -3.0, 0.0, say="mine")
FAR = Thing("taker_2", "taker", 9.0, 0.0)
VIEW = WorldView(
    (KEEPER, BALL, NEAR, FAR),
    seconds=2.0,
    paths={"keeper_1": ["GotoBall", "ApproachBall(ball)"]},
    said=frozenset({"taker_1"}),
    ended=("taken",),
    reading=lambda agent, feature: {"DistanceTo(ball)": 5.0}.get(feature, float("nan")),
)


def comparison(what: str, *things: str, below=None, above=None) -> Distance:
    kind = {"distance": Distance, "bearing": Bearing, "speed": Speed}[what]
    return kind(**{what: list(things)}, below=below, above=above)


def test_a_condition_holds_when_it_should():
    for condition, holds in [
        (comparison("distance", "keeper_1", "ball", below=5.1), True),
        (comparison("distance", "keeper_1", "ball", below=5.0), False),
        (comparison("distance", "keeper_1", "ball", above=4.9, below=5.1), True),
        (comparison("distance", "keeper_1", "closest taker", below=3.1), True),
        (comparison("distance", "taker_2", "closest taker", above=11.9), True),
        (comparison("bearing", "keeper_1", "ball", above=89, below=91), True),
        (comparison("bearing", "keeper_1", "taker_1", above=179), True),
        (comparison("speed", "keeper_1", above=4.9, below=5.1), True),
        (ActiveState(active="GotoBall", agent="keeper_1"), True),
        (ActiveState(active="ApproachBall", agent="keeper_1"), True),
        (ActiveState(active="ApproachBall(ball)", agent="keeper_1"), True),
        (ActiveState(active="Pass", agent="keeper_1"), False),
        (ActiveState(active="GotoBall", agent="keeper_2"), False),
        (FeatureValue(feature="DistanceTo(ball)", agent="keeper_1", below=5.1), True),
        (FeatureValue(feature="DistanceTo(ball)", agent="keeper_1", below=5.1, above=5.0), False),
        (FeatureValue(feature="Unseen", agent="keeper_1", below=5.0), False),
        (Said(said="taker_1"), True),
        (Said(said="keeper_1"), False),
        (Ended(ended="taken"), True),
        (Ended(ended="out"), False),
        (Ended(ended="any"), True),
        (Passed(seconds=2.0), True),
        (Passed(seconds=2.1), False),
        (All(all=[Passed(seconds=1), Said(said="taker_1")]), True),
        (All(all=[Passed(seconds=1), Said(said="ball")]), False),
        (AnyOf(any=[Passed(seconds=9), Said(said="taker_1")]), True),
        (Not(**{"not": Passed(seconds=9)}), True),
    ]:
        assert condition.holds(VIEW) is holds
        assert condition.describe(VIEW)


def test_a_thing_that_is_not_there_is_told_with_what_was_meant():
    with pytest.raises(LessonError, match=r'no "bal" in the world .*Did you mean "ball"'):
        VIEW.distance("keeper_1", "bal")
    with pytest.raises(LessonError, match=r'no "robot" here \(known: ball, keeper, taker\)'):
        VIEW.distance("keeper_1", "closest robot")


def test_without_a_world_only_what_agents_say_can_be_asked_for():
    nowhere = WorldView(None, 1.0, {"robot": ["GoFast"]})
    assert ActiveState(active="GoFast", agent="robot").holds(nowhere)
    with pytest.raises(LessonError, match='the place of "robot" is unknown'):
        nowhere.distance("robot", "ball")
    with pytest.raises(LessonError, match="the feature values of robot"):
        nowhere.reading("robot", "DistanceTo(ball)")
