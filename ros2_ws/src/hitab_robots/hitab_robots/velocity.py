"""Velocities of a robot's base: their limits, and when the robot has to stand still.

No ROS here. A velocity is ``(ahead, left, turn)`` in m/s, m/s and rad/s (REP 103).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from hitab_core import VocabularyError

Velocity = tuple[float, float, float]

NO_VELOCITY: Velocity = (0.0, 0.0, 0.0)

REST_S = 1.0
"""How long a robot that has to stand still is sent zeros, s; then others may drive it."""

BREAK_S = 3.0
"""An agent that falls silent for so long, s, while it moves does not drive again by itself."""

STEP_MAX_S = 0.25
"""The longest time between two velocities, s, for which a base may gain speed."""


@dataclass(frozen=True)
class Drive:
    """How a robot's base is driven; the numbers are those of its velocity.

    The names are those of Nav2's velocity smoother; the relay has parameters of the same names,
    whose defaults these are.

    Attributes:
        max_velocity: m/s, m/s, rad/s; also backwards. 0: it does not move so.
        max_accel: how fast it may gain speed, per s.
        max_decel: how fast it may lose speed, per s. A stop ignores this limit.
        enable_stamped_cmd_vel: whether the base takes `TwistStamped` instead of `Twist`.
    """

    max_velocity: Velocity = (0.5, 0.0, 2.5)
    max_accel: Velocity = (2.5, 0.0, 3.2)
    max_decel: Velocity = (2.5, 0.0, 3.2)
    enable_stamped_cmd_vel: bool = False

    @property
    def moves(self) -> bool:
        """Whether there is a base at all; one that may not move at any speed is none."""
        return any(self.max_velocity)

    def __post_init__(self) -> None:
        for name in ("max_velocity", "max_accel", "max_decel"):
            limits = getattr(self, name)
            if len(limits) != 3 or not all(0.0 <= limit < math.inf for limit in limits):
                raise VocabularyError(
                    f"{name} of a drive is {list(limits)}; it must be three numbers from 0 on: "
                    "ahead, to the left, turning"
                )

    def clipped(self, velocity: Sequence[float]) -> Velocity:
        """Return a velocity within the limits of speed; standing still if it is no velocity."""
        if not is_velocity(velocity):
            return NO_VELOCITY
        ahead, left, turn = (
            max(-most, min(most, wanted))
            for wanted, most in zip(velocity, self.max_velocity, strict=True)
        )
        return ahead, left, turn

    def towards(self, wanted: Sequence[float], now: Velocity, seconds: float) -> Velocity:
        """Return the velocity after some time on the way to the wanted one.

        Args:
            wanted: where to; within the limits or not.
            now: the present velocity.
            seconds: how long there was to change it.
        """
        seconds = max(0.0, min(seconds, STEP_MAX_S))
        ahead, left, turn = (
            _towards(to, at, gain * seconds, loss * seconds)
            for to, at, gain, loss in zip(
                self.clipped(wanted), now, self.max_accel, self.max_decel, strict=True
            )
        )
        return ahead, left, turn


def is_velocity(values: Sequence[float]) -> bool:
    """Whether a velocity is three numbers, none of them infinite or NaN."""
    return len(values) == 3 and all(map(math.isfinite, values))


def _towards(wanted: float, now: float, gain: float, loss: float) -> float:
    """Return a speed on the way from one to another, through standing still if it turns round."""
    if now * wanted < 0.0:
        wanted = 0.0
    step = gain if abs(wanted) > abs(now) else loss
    return now + max(-step, min(step, wanted - now))


class _Commanded:
    """The velocity of one source, and when it was last sent.

    Attributes:
        velocity: within the limits.
        since: s; when it was commanded.
        moved: whether it was a motion.
    """

    def __init__(self) -> None:
        self.velocity = NO_VELOCITY
        self.moved = False
        self.since = -math.inf


class Gate:
    """Decides which velocity a base gets: the commanded one, none, or zero.

    A person who drives by hand counts, and not the agent, until the person is silent.

    Attributes:
        held: whether the robot has to stand still, whatever is commanded.
        insists: whether zeros are sent as long as it is held, to keep other drivers out.
        closed: whether nothing more will pass.
        silent: whether every last command is too old.
    """

    def __init__(self, drive: Drive, timeout: float, now: float) -> None:
        """Let nothing pass yet: send zeros, since the base may hold an older velocity.

        Args:
            drive: the limits.
            timeout: s; a command that is older counts for nothing.
            now: s; any steady clock.
        """
        self.held = self.insists = self.closed = False
        self.silent = True
        self._drive = drive
        self._timeout = timeout
        self._velocity = NO_VELOCITY
        self._agent, self._person = _Commanded(), _Commanded()
        self._before = now
        self.rest(now)

    def command(self, velocity: Sequence[float], now: float, *, by_hand: bool = False) -> str:
        """Take a command; return why the robot must not obey unasked, or an empty text.

        One that is no number, infinite or NaN has the robot stand still.

        Args:
            velocity: the wanted one.
            now: s.
            by_hand: whether a person commands it, and not the agent.
        """
        commanded = self._person if by_hand else self._agent
        broke_off = commanded.moved and not by_hand and now - commanded.since > BREAK_S
        commanded.velocity = self._drive.clipped(velocity)
        commanded.moved = commanded.velocity != NO_VELOCITY
        commanded.since = now
        if is_velocity(velocity):
            return f"fell silent for over {BREAK_S:g} s while it moved" if broke_off else ""
        if commanded is self._counting(now):
            self._velocity = NO_VELOCITY
        return f"commands {velocity}, which is no velocity"

    def velocity(self, now: float) -> Velocity | None:
        """Return the velocity to send to the base now; None leaves the base to other drivers."""
        seconds, self._before = now - self._before, now
        commanded = None if self.closed else self._counting(now)
        self.silent = commanded is None
        if self.held or commanded is None:
            moved = self._velocity != NO_VELOCITY
            self._velocity = self._agent.velocity = self._person.velocity = NO_VELOCITY
            self._agent.moved &= not self.held  # a person has it move again
            if moved or (self.held and self.insists and not self.closed):
                self.rest(now)
            return NO_VELOCITY if now <= self._rest_until else None
        self._velocity = self._drive.towards(commanded.velocity, self._velocity, seconds)
        self.rest(now)
        return self._velocity

    def rest(self, now: float) -> None:
        """Send zeros for a while, whenever there is nothing else to send."""
        self._rest_until = now + REST_S

    def _counting(self, now: float) -> _Commanded | None:
        """Return whose command counts; None if no command counts."""
        for commanded in (self._person, self._agent):
            if 0.0 <= now - commanded.since <= self._timeout:
                return commanded
        return None
