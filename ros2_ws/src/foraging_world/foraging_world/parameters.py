"""The parameters of the foraging world. Lengths are in m, times in s, angles in rad."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType

from hitab_world.parameters import NOT_NEGATIVE, ParameterError, Parameters, at_least


@dataclass(frozen=True)
class ForagingParameters(Parameters):
    """Parameters of the field, the boxes and the robots.

    Attributes:
        foragers: number of robots.
        squad_size: number of consecutive robots that share a radio channel for positions and held
            boxes: 1 to 5, 6 to 10 and so on.
        company_squads: number of consecutive squads that share a second channel.
        scouts: number of scouts in each squad, 0 for none. The first robots of a squad are its
            scouts; they cannot grip, and have their own range of sight. With scouts, robots are
            called scout_1, ..., carrier_1, ..., instead of forager_1, ....
        scout_sight: range at which scouts see boxes, m.
        width, height: size of the field, which is centered on the origin, m.
        home_radius: radius of home, a disc in the middle, m. A box is home when its center is.
        obstacles: number of round obstacles.
        small_boxes, large_boxes: number of boxes on the field.
        small_pullers, large_pullers: how many robots must pull before a box moves.
        renew: whether a box that has come home is put elsewhere on the field again, so that
            their number is constant; otherwise the episode ends when all are home.
        duration: duration of an episode, s.
        sight: range at which boxes are seen, m, from the robot's center to the box's edge.
        obstacle_sight: range at which obstacles and walls are seen, m, edge to edge.
        reach: range at which a box can be gripped, m, edge to edge.
        speed, turn_rate: maximum of a robot, m/s and rad/s.
        pull_speed: maximum speed of a box, m/s.
        noise: relative standard deviation of each turn and each distance covered.
    """

    WORLD = "foraging"
    LIMITS = MappingProxyType(
        {
            **dict.fromkeys(("width", "height"), at_least(10.0, "m")),
            **dict.fromkeys(
                ("scouts", "obstacles", "small_boxes", "large_boxes", "noise"), NOT_NEGATIVE
            ),
        }
    )

    foragers: int = 50
    squad_size: int = 5
    company_squads: int = 5
    scouts: int = 0
    scout_sight: float = 12.0
    width: float = 60.0
    height: float = 60.0
    home_radius: float = 4.0
    obstacles: int = 12
    small_boxes: int = 10
    large_boxes: int = 2
    small_pullers: int = 5
    large_pullers: int = 25
    renew: bool = True
    duration: float = 600.0
    sight: float = 6.0
    obstacle_sight: float = 1.5
    reach: float = 0.3
    speed: float = 1.0
    turn_rate: float = 2.0
    pull_speed: float = 0.5
    noise: float = 0.05

    forager_radius: float = 0.2
    small_radius: float = 0.6
    large_radius: float = 2.5
    obstacle_radius: float = 1.2

    def __post_init__(self) -> None:
        """Refuse values that are invalid or leave no room."""
        super().__post_init__()
        if self.foragers * 4.0 * self.forager_radius**2 > 0.5 * self.width * self.height:
            raise ParameterError(
                f"foragers is {self.foragers}: they do not fit into half of the field of "
                f"{self.width:g} m by {self.height:g} m; make it larger"
            )
        for size in ("small", "large"):
            pullers = getattr(self, f"{size}_pullers")
            if pullers > self.places_around(getattr(self, f"{size}_radius")):
                raise ParameterError(
                    f"{size}_pullers is {pullers}: so many robots do not fit around a box with a "
                    f"radius of {getattr(self, f'{size}_radius'):g} m; make {size}_radius larger"
                )

    def places_around(self, radius: float) -> int:
        """Return how many robots fit side by side around a box with this radius, m."""
        return int(math.pi / math.asin(self.forager_radius / (radius + self.forager_radius)))

    @property
    def ring_width(self) -> float:
        """Width of the ring around a box for the robots that hold it, m."""
        return self.reach + 2.0 * self.forager_radius

    @property
    def largest_radius(self) -> float:
        """Radius of the largest box with its ring of pulling robots, m."""
        return max(self.small_radius, self.large_radius) + self.ring_width
