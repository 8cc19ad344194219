"""Features and targets that look ahead, in addition to `keepaway_world.features`."""

from __future__ import annotations

import math

from hitab_core import Feature, FeatureKind, Target
from keepaway_research.predictive.body import PredictiveBody
from keepaway_research.predictive.lanes import clearance
from keepaway_world import percept
from keepaway_world.body import NO_PLAYER
from keepaway_world.features import NAN
from keepaway_world.percept import BALL


def a_teammate_is_faster_to_ball(body: PredictiveBody) -> float:
    """Whether another keeper could meet the ball in fewer cycles, ignoring headings.

    All keepers are judged by the same estimate, so that two keepers seldom wait for each other.
    """
    return float(body.soonest_mate() < body.cycles_to_meet(body.position))


def lane_clearance(body: PredictiveBody, place: int) -> float:
    """Return the distance of the nearest taker from the line between ball and teammate, m.

    It is NaN if there is no such teammate and the box's diagonal if there are no takers.
    """
    if place < 0:
        return NAN
    takers = [body.place_of(taker) for taker in body.takers]
    clear = clearance(body.place_of(BALL), body.place_of(place), takers)
    return min(clear, math.hypot(body.values[percept.WIDTH], body.values[percept.HEIGHT]))


def farthest_keeper(body: PredictiveBody) -> int:
    """Return the place of the farthest other keeper; on a tie, the highest number."""
    return max(body.others, key=lambda place: (body.values[place], place), default=NO_PLAYER)


FEATURES = (
    Feature(
        "ATeammateIsFasterToBall",
        a_teammate_is_faster_to_ball,
        FeatureKind.BOOLEAN,
        description="another keeper could meet the rolling ball sooner",
    ),
    Feature(
        "LaneClearance",
        lane_clearance,
        parameters=("X",),
        unit="m",
        description="distance of the nearest taker to the way of a pass to X",
    ),
)

TARGETS = (Target("farthest_keeper", farthest_keeper, "the farthest other keeper"),)
