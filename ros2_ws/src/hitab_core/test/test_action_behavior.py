"""A basic behavior that is an action sends a goal, cancels it, and raises a flag at its end."""

from __future__ import annotations

import math
from typing import Any

import pytest

from hitab_core import (
    ActionBehavior,
    ActionCall,
    BasicBehavior,
    Domain,
    HitabError,
    Repertoire,
    Target,
    Term,
    calls_of,
    feedback_feature,
)
from hitab_core.running import FeatureCache, RunContext, performance


class Body:
    """A body that knows where it is to go."""

    def __init__(self, name: str = "") -> None:
        self.place = (1.0, 2.0)
        self.pulses = 0


def pulse(body: Body, place: Any) -> None:
    body.pulses += 1


DOMAIN = Domain.of(
    "walkers",
    "1",
    Body,
    behaviors=[
        ActionBehavior(
            "GoTo",
            pulse,
            parameters=("X",),
            action_type="nav2_msgs/action/NavigateToPose",
            action="navigate_to_pose",
            goal={"frame": "map", "x": lambda body, place: place[0]},
        ),
        BasicBehavior("Rest"),
    ],
    features=[
        feedback_feature("Left", "GoTo", "distance"),
        feedback_feature("Took", "GoTo", "time", otherwise=-1.0),
    ],
    targets=[Target("there", lambda body: body.place)],
)


class Carrier:
    """Keeps the calls."""

    def __init__(self) -> None:
        self.done: list[str] = []

    def begin(self, call: ActionCall) -> None:
        self.done.append(f"begin {call.term} {dict(call.goal)}")

    def leave(self, call: ActionCall) -> None:
        self.done.append(f"leave {call.term}")

    def failed(self, call: ActionCall) -> None:
        self.done.append(f"failed {call.term}")


@pytest.fixture
def body() -> Body:
    made = Body()
    calls_of(made).carrier = Carrier()
    return made


def performing(body: Any) -> Any:
    context = RunContext(Repertoire(DOMAIN), body, FeatureCache(body, DOMAIN), lambda: 0.0)
    return performance(context, Term("GoTo", ("there",)))


def test_the_first_pulse_sends_the_goal_and_leaving_cancels_it(body):
    running, carrier = performing(body), calls_of(body).carrier
    running.start()
    assert carrier.done == []
    running.tick()
    running.tick()
    assert carrier.done == ["begin GoTo(there) {'frame': 'map', 'x': 1.0}"]
    assert body.pulses == 2
    running.stop()
    running.stop()
    assert carrier.done[1:] == ["leave GoTo(there)"]
    assert calls_of(body).current is None


def test_a_state_that_is_left_before_its_first_pulse_sends_nothing(body):
    running = performing(body)
    running.start()
    running.stop()
    assert calls_of(body).carrier.done == []


def test_the_flag_stays_up_until_the_state_is_left(body):
    running = performing(body)
    running.start()
    running.tick()
    calls_of(body).current.succeed()
    assert running.raised == set()
    running.tick()
    assert running.raised == {"Done"}
    running.raised.clear()  # as the parent does once it has seen it
    running.tick()
    assert running.raised == {"Done"}
    running.stop()
    running.start()
    running.tick()
    assert running.raised == set()


def test_what_is_over_does_not_change_its_mind(body):
    running = performing(body)
    running.start()
    running.tick()
    call = calls_of(body).current
    assert call.fail("the door is shut")
    call.succeed()
    assert not call.fail("the light is off")
    assert (call.outcome, call.why) == ("Failed", "the door is shut")
    running.stop()
    running.start()
    running.tick()
    late, call = call, calls_of(body).current
    late.succeed()
    assert not call.outcome
    running.stop()
    call.succeed()
    assert not call.outcome


def test_a_goal_that_cannot_be_made_fails_and_names_the_field(body):
    body.place = None
    running = performing(body)
    running.start()
    running.tick()
    assert running.raised == {"Failed"}
    assert calls_of(body).current.why.startswith('the field "x" of its goal could not be made')
    assert calls_of(body).carrier.done == ["failed GoTo(there)"]


def test_without_anybody_who_carries_out_actions_they_fail():
    body = Body()
    running = performing(body)
    running.start()
    running.tick()
    assert running.raised == {"Failed"}
    assert "this program carries out no actions" in calls_of(body).current.why
    running.stop()


def test_feedback_is_read_while_its_behavior_is_performed(body):
    left, took = DOMAIN.features["Left"].read, DOMAIN.features["Took"].read
    running = performing(body)
    running.start()
    running.tick()
    with pytest.raises(HitabError, match='there is no feedback of "GoTo"'):
        left(body)
    assert took(body) == -1.0

    class Lasting:
        sec, nanosec = 3, 500_000_000

    class Feedback:
        distance, time = 4, Lasting()

    calls_of(body).current.feedback = Feedback()
    assert left(body) == 4.0
    assert took(body) == 3.5
    running.stop()
    assert math.isclose(took(body), -1.0)
