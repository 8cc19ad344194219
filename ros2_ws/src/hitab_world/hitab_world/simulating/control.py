"""The control of a world: the settings that its services change and a restart keeps."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, get_type_hints

from hitab_msgs.msg import WorldStatus

from hitab_world.node.settings import WorldSettings


@dataclass
class Control:
    """The control of a world; files store the fields under these names.

    Attributes:
        pace: whether the world waits for its agents; see `WorldSettings`.
        factor: speed in real-time pace, as a factor of real time.
        paused: whether the world is paused, except for the cycles of ``steps_left``.
        steps_left: cycles to play while paused.
        episodes_left: episodes to play until the world pauses; 0 for no limit.
        run: number of the last run, unique among all runs.
        teaching: further factor while an agent is taught; 1 for none.
        held: why the world rests in spite of all requests, such as an emergency stop; else empty.
            It is not stored.
        reached: why the world paused by itself, such as at a breakpoint; else empty. It is not
            stored.
    """

    pace: str
    factor: float
    paused: bool
    teaching: float = 1.0
    steps_left: int = 0
    episodes_left: int = 0
    run: int = field(default_factory=time.time_ns)
    held = ""
    reached = ""

    @property
    def lockstep(self) -> bool:
        """Whether the next cycle begins when every agent has answered."""
        return self.pace == WorldStatus.LOCKSTEP

    @property
    def at_rest(self) -> bool:
        """Whether no cycle should be played now."""
        return bool(self.held) or (self.paused and not self.steps_left)

    def pause(self, reached: str = "") -> None:
        """Pause the world; ``reached`` what it paused at by itself."""
        self.paused = True
        self.steps_left = 0
        self.reached = reached

    def resume(self) -> None:
        """Run until something pauses the world."""
        self.paused = False
        self.steps_left = 0
        self.reached = ""

    def step(self, cycles: int) -> None:
        """Play some cycles, then pause."""
        self.paused = True
        self.steps_left = cycles
        self.reached = ""

    def take_over(self, other: Control) -> None:
        """Take over the control of another process's world."""
        vars(self).update(vars(other))

    @classmethod
    def read(cls, values: Mapping[str, Any]) -> Control:
        """Return the control with these values, as ``dataclasses.asdict`` gives them.

        Raises:
            HitabError, LookupError, TypeError, ValueError: if a value is missing or invalid.
        """
        control = cls(**values)
        for name, kind in get_type_hints(cls).items():
            value = getattr(control, name)
            if type(value) is not kind or (kind is int and value < 0):
                raise TypeError(f"{name} is {value!r}")
        WorldSettings(pace=control.pace, factor=control.factor, teaching=control.teaching)
        return control
