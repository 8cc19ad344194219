"""The parameters of a world's node."""

from __future__ import annotations

from dataclasses import dataclass, fields
from types import MappingProxyType

from hitab_msgs.msg import WorldStatus
from rclpy.node import Node

from hitab_world.node.ros_parameters import declare
from hitab_world.parameters import NOT_NEGATIVE, Parameters, between, one_of

WORLD_PARAMETERS = {
    "pace": "lockstep: the next cycle begins when every agent has answered; realtime",
    "factor": "speed in real-time pace, as a factor of real time",
    "teaching": "further factor in real-time pace while an agent is taught; 1: none",
    "seed": "of the run: episode i is seeded with it and i",
    "paused": "wait for a resume, step or play before the first cycle",
    "deadline": "s; in lockstep, how long to wait for an agent's answer",
    "hosts": "how many hosts a world that has just started waits for before it plays",
    "swarm": "identity of its swarm; empty if none, and nothing to resume",
    "machines": "machines of its swarm, whose hosts alone may run agents; empty for one machine",
    "state_dir": "folder in which its state survives a restart of its process; empty if none",
    "snapshot_period": "s; how often its state is saved for a restart; 0 for never",
    "state_rate": "Hz; how often the true state is published while running",
}


@dataclass(frozen=True)
class WorldSettings(Parameters):
    """The parameters of a world's node; each field is a ROS parameter, described above."""

    WORLD = "world"
    LIMITS = MappingProxyType(
        {
            "pace": one_of(WorldStatus.LOCKSTEP, WorldStatus.REALTIME),
            "factor": between(0.01, 1000.0),
            "teaching": between(0.01, 1.0),
            "deadline": between(0.001, 3600.0),
            "state_rate": between(0.1, 1000.0),
            "snapshot_period": between(0.0, 3600.0),
            "seed": NOT_NEGATIVE,
            "hosts": NOT_NEGATIVE,
        }
    )

    pace: str = WorldStatus.REALTIME
    factor: float = 1.0
    teaching: float = 0.5
    seed: int = 0
    paused: bool = False
    deadline: float = 5.0
    state_rate: float = 30.0
    hosts: int = 0
    swarm: str = ""
    machines: tuple[str, ...] = ()
    state_dir: str = ""
    snapshot_period: float = 1.0

    @classmethod
    def declare(cls, node: Node) -> WorldSettings:
        """Declare the parameters and return their values.

        Raises:
            HitabError: if a parameter has another type, or is out of its range.
        """
        return cls(
            **{s.name: declare(node, s.name, s, WORLD_PARAMETERS[s.name]) for s in fields(cls)}
        )
