"""The features and targets of foragers."""

from __future__ import annotations

from collections.abc import Callable

from foraging_world import percept
from foraging_world.body import ForagerBody
from foraging_world.percept import LARGE
from hitab_core import Feature, FeatureKind, Target


def distance_to(body: ForagerBody, place: int) -> float:
    """Return the distance to X, m, edge to edge; 1000 if it is not seen or there is none."""
    return body.values[place]


def direction_to(body: ForagerBody, place: int) -> float:
    """Return the direction of X relative to the body, rad; 0 (an obstacle: pi) if not seen."""
    return body.values[place + 1]


def sees(body: ForagerBody, place: int) -> float:
    """Whether X is seen or known by radio."""
    return float(body.sees(place))


def can_grip(body: ForagerBody, place: int) -> float:
    """Whether X is a box in reach, and no box is held."""
    values = body.values
    return float(
        values[place + 2] > 0.0
        and values[place] <= values[percept.REACH]
        and values[percept.HELD] == 0.0
    )


def holds(body: ForagerBody, place: int) -> float:
    """Whether X is the box that the forager holds."""
    return float(body.held > 0.0 and body.held == body.values[place + 2])


def percept_value(index: int) -> Callable[[ForagerBody], float]:
    """Return a feature's reading of one value of the percept."""
    return lambda body: body.values[index]


FEATURES = (
    Feature("DistanceTo", distance_to, parameters=("X",), unit="m", description="distance to X"),
    Feature(
        "DirectionTo",
        direction_to,
        FeatureKind.TOROIDAL,
        parameters=("X",),
        unit="rad",
        description="direction to X relative to the body, counter-clockwise",
    ),
    Feature("Sees", sees, FeatureKind.BOOLEAN, ("X",), description="X is seen, or known by radio"),
    Feature(
        "CanGrip",
        can_grip,
        FeatureKind.BOOLEAN,
        ("X",),
        description="box X is in reach, none is held",
    ),
    Feature("Holds", holds, FeatureKind.BOOLEAN, ("X",), description="box X is held"),
    Feature(
        "HoldsABox",
        lambda body: float(body.held > 0.0),
        FeatureKind.BOOLEAN,
        description="some box is held",
    ),
    Feature(
        "HoldsALargeBox",
        lambda body: float(body.values[percept.HELD_SIZE] == LARGE),
        FeatureKind.BOOLEAN,
        description="a large box is held",
    ),
    Feature(
        "Hands",
        percept_value(percept.HANDS),
        description="how many foragers hold the box that is held",
    ),
    Feature(
        "Waited",
        percept_value(percept.WAITED),
        unit="s",
        description="how long the box held has not moved",
    ),
    Feature(
        "Rested",
        percept_value(percept.RESTED),
        unit="s",
        description="how long ago a box was given up",
    ),
)


def _target(name: str, place: int, description: str) -> Target:
    """Return a target that is always the same place of the percept."""
    return Target(name, lambda body: place, description)


TARGETS = (
    _target("home", percept.HOME, "the middle of home"),
    _target("closest_box", percept.BOX, "the closest box in sight"),
    _target("closest_small_box", percept.SMALL_BOX, "the closest small box in sight"),
    _target("closest_large_box", percept.LARGE_BOX, "the closest large box in sight"),
    _target(
        "closest_attached_box", percept.ATTACHED_BOX, "the closest box in sight that others hold"
    ),
    _target(
        "squad_box", percept.SQUAD_BOX, "the box that most of the own squad hold, known by radio"
    ),
    _target(
        "company_box",
        percept.COMPANY_BOX,
        "the large box that most of the own company hold, known by radio",
    ),
    _target("squad_centre", percept.SQUAD_CENTRE, "the middle of the own squad"),
    _target("closest_obstacle", percept.OBSTACLE, "the closest obstacle or wall"),
)
