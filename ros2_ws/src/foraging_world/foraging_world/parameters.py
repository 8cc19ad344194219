"""All settable figures of the foraging world. Lengths in m, times in s, angles in rad."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType

from hitab_world.parameters import NOT_NEGATIVE, ParameterError, Parameters, at_least


@dataclass(frozen=True)
class ForagingParameters(Parameters):
    """Figures of the field, the boxes and the robots.

    Attributes:
        foragers: number of robots.
        squad_size: robots of successive numbers that share a radio channel, on which each
            tells where it is and which box it holds: 1 to 5, 6 to 10 and so on.
        company_squads: squads of successive numbers that share a second channel.
        width, height: of the field, which is centred on the origin, m.
        home_radius: of the home, a disc in the middle, m. A box is home when its centre is.
        obstacles: number of round obstacles.
        small_boxes, large_boxes: how many lie about.
        small_pullers, large_pullers: how many robots must pull before a box moves.
        renew: whether a box that has come home lies somewhere else again, so that there are
            always as many; otherwise the episode ends when all are home.
        duration: of an episode, s.
        sight: how far boxes are seen, m, from the robot's centre to the box's edge.
        obstacle_sight: how far obstacles and walls are seen, m, edge to edge.
        reach: how far a box can be gripped, m, edge to edge.
        speed, turn_rate: the most a robot does, m/s and rad/s.
        pull_speed: the most a box moves at, m/s.
        noise: standard deviation of what each turn and each distance covered differ by, as a
            part of them.
    """

    WORLD = "foraging"
    LIMITS = MappingProxyType(
        {
            **dict.fromkeys(("width", "height"), at_least(10.0, "m")),
            **dict.fromkeys(("obstacles", "small_boxes", "large_boxes", "noise"), NOT_NEGATIVE),
        }
    )

    foragers: int = 50
    squad_size: int = 5
    company_squads: int = 5
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
        """Refuse figures that mean nothing, or that leave no room."""
        super().__post_init__()
        if self.foragers * 4.0 * self.forager_radius**2 > 0.5 * self.width * self.height:
            raise ParameterError(
                f"foragers is {self.foragers}: they do not fit into half of the field of "
                f"{self.width:g} m by {self.height:g} m; make it wider"
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
        """Of the ring around a box in which the robots are that hold it, m."""
        return self.reach + 2.0 * self.forager_radius

    @property
    def largest_radius(self) -> float:
        """Of a large box with its ring of pulling robots, m."""
        return max(self.small_radius, self.large_radius) + self.ring_width
