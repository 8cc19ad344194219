"""The keepers' features and targets (the paper, section 6)."""

from __future__ import annotations

import math
from functools import partial

from hitab_core import Feature, FeatureKind, Target
from keepaway_world.body import CORNERS, NO_PLAYER, YELL, KeeperBody
from keepaway_world.percept import BALL

NAN = float("nan")


def distance_to(body: KeeperBody, place: int) -> float:
    """Return the distance between the centers, m; NaN if there is no such player."""
    if place >= 0:
        return body.values[place]
    return NAN if place == NO_PLAYER else body.corner(place)[0]


def direction_to(body: KeeperBody, place: int) -> float:
    """Return the direction relative to the body, rad on [-pi, pi], counter-clockwise."""
    if place >= 0:
        return body.values[place + 1]
    return NAN if place == NO_PLAYER else body.corner(place)[1]


def i_was_yelled_at(body: KeeperBody) -> float:
    """Whether a passer's yell to this keeper was heard in this cycle, and only then."""
    return float(bool(body.heard) and YELL.format(body.number) in body.heard)


def ball_is_kickable(body: KeeperBody) -> float:
    """Whether the ball is within kicking range, as far as the keeper can see."""
    return float(body.ball_is_kickable)


def a_teammate_is_closer_to_ball(body: KeeperBody) -> float:
    """Whether another keeper is closer to the ball, as far as the keeper can see."""
    values = body.values
    own, bearing = values[BALL], values[BALL + 1]
    for place in body.others:
        away = values[place]
        # |other - ball|² < |ball|², both relative to the keeper
        if away < 2.0 * own * math.cos(values[place + 1] - bearing):
            return 1.0
    return 0.0


def _corner(place: int, body: KeeperBody) -> int:
    return place


FEATURES = (
    Feature(
        "DistanceTo",
        distance_to,
        parameters=("X",),
        unit="m",
        description="distance to X",
    ),
    Feature(
        "DirectionTo",
        direction_to,
        FeatureKind.TOROIDAL,
        parameters=("X",),
        unit="rad",
        description="direction to X relative to the body, counter-clockwise",
    ),
    Feature(
        "IWasYelledAt",
        i_was_yelled_at,
        FeatureKind.BOOLEAN,
        description="a passer has just yelled to this keeper",
    ),
    Feature(
        "BallIsKickable",
        ball_is_kickable,
        FeatureKind.BOOLEAN,
        description="the ball is within kicking range",
    ),
    Feature(
        "ATeammateIsCloserToBall",
        a_teammate_is_closer_to_ball,
        FeatureKind.BOOLEAN,
        description="another keeper is closer to the ball",
    ),
)

TARGETS = (
    Target("ball", lambda body: BALL, "the ball"),
    Target("closest_keeper", KeeperBody.closest_keeper, "the closest other keeper"),
    Target("closest_taker", KeeperBody.closest_taker, "the closest taker"),
    *(
        Target(f"{name}_corner", partial(_corner, place), f"the box's {name} corner")
        for name, place in zip(
            ("top_left", "top_right", "bottom_right", "bottom_left"), CORNERS, strict=True
        )
    ),
)
