"""Features and targets for takers at full speed, in addition to `keepaway_research.predictive`."""

from __future__ import annotations

import math

from hitab_core import Feature, FeatureKind, Target
from keepaway_research.fullspeed.body import FullSpeedBody
from keepaway_world.body import NO_PLAYER
from keepaway_world.features import NAN
from keepaway_world.percept import HEIGHT, WIDTH


def ball_is_anothers(body: FullSpeedBody) -> float:
    """Whether another keeper has the ball, is passed to, or could meet it sooner."""
    return float(body.ball_is_anothers)


def taker_to_ball(body: FullSpeedBody) -> float:
    """Return the distance of the nearest taker to the ball, m; the box's diagonal without any."""
    return min(body.taker_to_ball, math.hypot(body.values[WIDTH], body.values[HEIGHT]))


def lane_slack(body: FullSpeedBody, mate: int) -> float:
    """Return by how much the takers miss a pass to a mate, m; NaN if it is no mate.

    It is -9 m if the ball is not kickable or cannot get there, the box's diagonal without takers.
    """
    if mate not in body.others:
        return NAN
    return min(body.lane(mate).slack, math.hypot(body.values[WIDTH], body.values[HEIGHT]))


def clearest_keeper(body: FullSpeedBody) -> int:
    """Return the place of the teammate whose lane has the most slack."""
    return max(body.others, key=lambda mate: body.lane(mate).slack, default=NO_PLAYER)


FEATURES = (
    Feature(
        "BallIsAnothers",
        ball_is_anothers,
        FeatureKind.BOOLEAN,
        description="another keeper has the ball, is passed to, or could meet it sooner",
    ),
    Feature(
        "TakerToBall",
        taker_to_ball,
        unit="m",
        description="distance of the nearest taker to the ball",
    ),
    Feature(
        "LaneSlack",
        lane_slack,
        parameters=("X",),
        unit="m",
        description="by how much the takers miss a pass to X; below 0 they get it",
    ),
)

TARGETS = (
    Target("clearest_keeper", clearest_keeper, "the teammate whose lane has the most slack"),
)
