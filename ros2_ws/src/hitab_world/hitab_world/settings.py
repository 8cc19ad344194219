"""The parameters of a world's node."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hitab_msgs.msg import WorldStatus
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

from hitab_core import HitabError, unknown

DESCRIPTIONS = {
    "pace": "lockstep: the next cycle begins when every agent has answered; realtime",
    "factor": "speed in real-time pace, as a factor of real time",
    "seed": "of the run: episode i is seeded with it and i",
    "paused": "wait for a resume, step or play before the first cycle",
    "deadline": "s; in lockstep, how long to wait for an agent's answer",
    "swarm": "identity of its swarm; empty: none, and nothing to resume",
    "state_dir": "folder in which its state survives a restart of its process; empty: none",
    "snapshot_period": "s; how often its state is saved for a restart; 0: never",
    "state_rate": "Hz; how often the true state is published while running",
}
_FLOATS = {
    "factor": (0.01, 1000.0),
    "deadline": (0.001, 3600.0),
    "state_rate": (0.1, 1000.0),
    "snapshot_period": (0.0, 3600.0),
}


@dataclass(frozen=True, slots=True)
class WorldSettings:
    """How a world is run; each field is a ROS parameter, described above."""

    pace: str = WorldStatus.REALTIME
    factor: float = 1.0
    seed: int = 0
    paused: bool = False
    deadline: float = 5.0
    state_rate: float = 30.0
    swarm: str = ""
    state_dir: str = ""
    snapshot_period: float = 1.0

    @classmethod
    def declare(cls, node: Node) -> WorldSettings:
        """Declare the parameters and return their values.

        Raises:
            HitabError: if the pace is not one of the two.
        """
        values: dict[str, Any] = {}
        for name, description in DESCRIPTIONS.items():
            descriptor = ParameterDescriptor(description=description, read_only=True)
            if name in _FLOATS:
                low, high = _FLOATS[name]
                limits = FloatingPointRange(from_value=low, to_value=high)
                descriptor.floating_point_range = [limits]
            elif name == "seed":
                descriptor.integer_range = [IntegerRange(from_value=0, to_value=2**63 - 1, step=1)]
            default = cls.__dataclass_fields__[name].default
            values[name] = node.declare_parameter(name, default, descriptor).value
        check_pace(values["pace"])
        return cls(**values)


def check_factor(factor: float) -> None:
    """Check a speed as a factor of real time.

    Raises:
        HitabError: naming the smallest and the largest.
    """
    low, high = _FLOATS["factor"]
    if not low <= factor <= high:
        raise HitabError(
            f"factor {factor:g} is out of range; give one from {low:g} to {high:g}, "
            "or use pace lockstep"
        )


def check_pace(pace: str) -> None:
    """Check the name of a pace.

    Raises:
        HitabError: naming the known ones.
    """
    paces = (WorldStatus.LOCKSTEP, WorldStatus.REALTIME)
    if pace not in paces:
        raise HitabError(unknown("pace", pace, paces))
