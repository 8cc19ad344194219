"""What is known of the robots at one moment; frozen, as all that pages read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from hitab_studio.robots.listening import SensorState
from hitab_studio.robots.messages import Grid, Picture
from hitab_studio.scene import Scene


@dataclass(frozen=True)
class CameraState:
    """A robot's camera.

    Attributes:
        sensor: its connection; None: there is no camera, or a choice of several.
        number: of its last picture, another one for each.
        picture: the last one; None: there is none.
        choices: the topics among which a person has to choose.
    """

    sensor: SensorState | None = None
    number: int = 0
    picture: Picture | None = None
    choices: tuple[str, ...] = ()


@dataclass(frozen=True)
class MapState:
    """The map; fields as those of `CameraState`."""

    sensor: SensorState | None = None
    number: int = 0
    grid: Grid | None = None
    choices: tuple[str, ...] = ()


@dataclass(frozen=True)
class RobotState:
    """One robot.

    Attributes:
        sensors: of it, without its camera.
        camera: of it.
        notes: what has to be known to read what is drawn of it.
    """

    sensors: tuple[SensorState, ...] = ()
    camera: CameraState = field(default_factory=CameraState)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Robots:
    """All robots.

    Attributes:
        robots: by the names of their agents.
        scene: where they are; None: of none that is known.
        lost: names of robots whose odometry is silent: they were there.
        scans: what their scanners see, as it is sent to pages; empty: nothing new.
        map: of where they are.
    """

    robots: Mapping[str, RobotState] = field(default_factory=lambda: MappingProxyType({}))
    scene: Scene | None = None
    lost: frozenset[str] = frozenset()
    scans: bytes = b""
    map: MapState = field(default_factory=MapState)

    def of(self, agent: str) -> RobotState:
        """Return what is known of an agent's robot."""
        return self.robots.get(agent, NOTHING)


NOTHING = RobotState()
