"""A recorded change of state is compared with what is done again, bit by bit."""

import math
from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import TransitionEvent

from hitab_agent.retracing import DifferenceError, Retracer, Step
from hitab_ros import names


def event(**changes: Any) -> TransitionEvent:
    fields = {"agent": "a", "from_state": "Start", "to_state": "Go", "values": [1.5, math.nan]}
    return TransitionEvent(**{**fields, "features": ["X", "Y"], "probability": 1.0, **changes})


def retraced(recorded: TransitionEvent, now: Iterable[TransitionEvent]) -> int:
    """Return how many recorded changes agree with those of an agent in training."""
    agent = SimpleNamespace(mode=SimpleNamespace(value="training"), cycle=7)
    changes = [list(now), []]
    offline: Any = SimpleNamespace(agent=agent, transitions=lambda: changes.pop(0))
    retracer = Retracer(offline)
    retracer.take([Step(0, "other", None)])
    retracer._begun = True
    return retracer.take([Step(1, names.TRANSITIONS, recorded)]).compared


def test_the_same_change_agrees_also_if_a_value_is_missing():
    # A serialized message has random bytes between its fields, and NaN does not equal NaN.
    for length in range(8):
        name = "G" * length
        assert retraced(event(to_state=name), [event(to_state=name)]) == 1


def test_a_change_that_differs_in_a_bit_does_not():
    for changes in [
        {"values": [math.nextafter(1.5, 2.0), math.nan]},
        {"values": [1.5, 0.0]},
        {"to_state": "Stay"},
        {"probability": math.nextafter(1.0, 0.0)},
        {"commanded": True},
        {"features": ["X"]},
    ]:
        with pytest.raises(DifferenceError, match="went from Start"):
            retraced(event(**changes), [event()])
