"""The features and targets of foragers."""

from __future__ import annotations

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


def holds_a_box(body: ForagerBody) -> float:
    """Whether the forager holds any box."""
    return float(body.held > 0.0)


def holds_a_large_box(body: ForagerBody) -> float:
    """Whether the forager holds a large box."""
    return float(body.values[percept.HELD_SIZE] == LARGE)


def hands(body: ForagerBody) -> float:
    """Return how many foragers hold the box that this forager holds; 0 if it holds none."""
    return body.values[percept.HANDS]


def waited(body: ForagerBody) -> float:
    """Return for how long the held box has not moved, s."""
    return body.values[percept.WAITED]


def rested(body: ForagerBody) -> float:
    """Return the time since the forager last gave up a box, s; 1000 if it never did."""
    return body.values[percept.RESTED]


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
    Feature("HoldsABox", holds_a_box, FeatureKind.BOOLEAN, description="some box is held"),
    Feature(
        "HoldsALargeBox", holds_a_large_box, FeatureKind.BOOLEAN, description="a large box is held"
    ),
    Feature("Hands", hands, description="how many foragers hold the held box"),
    Feature("Waited", waited, unit="s", description="for how long the held box has not moved"),
    Feature("Rested", rested, unit="s", description="time since a box was given up"),
)

TARGETS = (
    Target("home", lambda body: percept.HOME, "the middle of home"),
    Target("closest_box", lambda body: percept.BOX, "the closest box in sight"),
    Target("closest_small_box", lambda body: percept.SMALL_BOX, "the closest small box in sight"),
    Target("closest_large_box", lambda body: percept.LARGE_BOX, "the closest large box in sight"),
    Target(
        "closest_attached_box",
        lambda body: percept.ATTACHED_BOX,
        "the closest box in sight that others hold",
    ),
    Target(
        "squad_box",
        lambda body: percept.SQUAD_BOX,
        "the box that most of the own squad hold, known by radio",
    ),
    Target(
        "company_box",
        lambda body: percept.COMPANY_BOX,
        "the large box that most of the own company hold, known by radio",
    ),
    Target("squad_centre", lambda body: percept.SQUAD_CENTRE, "the middle of the own squad"),
    Target("closest_obstacle", lambda body: percept.OBSTACLE, "the closest obstacle or wall"),
    Target("scout", lambda body: percept.SCOUT, "the first scout of the own squad"),
    Target(
        "scouted_box",
        lambda body: percept.SCOUTED_BOX,
        "the closest box that a scout of the own squad sees and no member of it holds",
    ),
)
