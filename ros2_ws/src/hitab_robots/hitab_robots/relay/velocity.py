"""Velocities of a robot's base: their limits, and the choice between their sources.

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
"""How long zeros are sent to a robot that has to stand still, s; then others may drive it."""

SILENT_S = 3.0
"""Silence of an agent, s, after which its robot must be re-armed, since nobody expects it to move
any more: no velocity during a motion, or no sign of life."""

STEP_MAX_S = 0.25
"""Largest time between two velocities, s, that counts for the limits of acceleration."""


@dataclass(frozen=True)
class Drive:
    """The drive of a robot's base: limits for each component of its velocity.

    The names are those of Nav2's velocity smoother. The relay has parameters of the same names,
    with these values as defaults.

    Attributes:
        max_velocity: largest speeds, m/s, m/s and rad/s, also backwards; 0 for no motion.
        max_accel: largest gain of speed, per s.
        max_decel: largest loss of speed, per s. A stop ignores this limit.
        enable_stamped_cmd_vel: whether the base takes `TwistStamped` instead of `Twist`.
    """

    max_velocity: Velocity = (0.5, 0.0, 2.5)
    max_accel: Velocity = (2.5, 0.0, 3.2)
    max_decel: Velocity = (2.5, 0.0, 3.2)
    enable_stamped_cmd_vel: bool = False

    @property
    def moves(self) -> bool:
        """Whether the robot has a base: at least one speed may differ from 0."""
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
        """Return a velocity within the limits of speed; zero for an invalid velocity."""
        if not is_velocity(velocity):
            return NO_VELOCITY
        ahead, left, turn = (
            max(-most, min(most, wanted))
            for wanted, most in zip(velocity, self.max_velocity, strict=True)
        )
        return ahead, left, turn

    def towards(self, wanted: Sequence[float], now: Velocity, seconds: float) -> Velocity:
        """Return the velocity after some time of changing it towards a wanted one.

        Args:
            wanted: the wanted velocity, within the limits or not.
            now: the present velocity.
            seconds: time since the present velocity was set.
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
    """Return a speed on the way to a wanted one; a change of direction passes through 0."""
    if now * wanted < 0.0:
        wanted = 0.0
    step = gain if abs(wanted) > abs(now) else loss
    return now + max(-step, min(step, wanted - now))


class _Commanded:
    """The velocity of one source, and when it was last sent.

    Attributes:
        velocity: the commanded velocity, within the limits.
        since: time of the command, s.
        moved: whether the command was a motion.
    """

    def __init__(self) -> None:
        self.velocity = NO_VELOCITY
        self.moved = False
        self.since = -math.inf


class Gate:
    """Decides which velocity a base gets: the commanded one, none, or zero.

    A person who drives by hand takes precedence over the agent until the person is silent.

    Attributes:
        held: whether the robot has to stand still, whatever is commanded.
        insists: whether zeros are sent as long as the robot is held, to keep other drivers out.
        closed: whether no command passes any more.
        silent: whether every last command is too old.
    """

    def __init__(self, drive: Drive, timeout: float, now: float) -> None:
        """Begin by sending zeros, since the base may hold an older velocity.

        Args:
            drive: the limits.
            timeout: age, s, from which on a command is ignored.
            now: time on any steady clock, s.
        """
        self.held = self.insists = self.closed = False
        self.silent = True
        self._drive = drive
        self._timeout = timeout
        self._velocity = NO_VELOCITY
        self._agent, self._person = _Commanded(), _Commanded()
        self._last_time = now
        self.rest(now)

    def command(self, velocity: Sequence[float], now: float, *, by_hand: bool = False) -> str:
        """Take a command; return why the robot must be re-armed first, or an empty text.

        An invalid velocity, such as one with NaN, makes the robot stand still.

        Args:
            velocity: the wanted velocity.
            now: present time, s.
            by_hand: whether the command comes from a person, not from the agent.
        """
        commanded = self._person if by_hand else self._agent
        broke_off = commanded.moved and not by_hand and now - commanded.since > SILENT_S
        commanded.velocity = self._drive.clipped(velocity)
        commanded.moved = commanded.velocity != NO_VELOCITY
        commanded.since = now
        if is_velocity(velocity):
            return f"fell silent for over {SILENT_S:g} s while it moved" if broke_off else ""
        if commanded is self._in_control(now):
            self._velocity = NO_VELOCITY
        return f"commands {velocity}, which is not a velocity"

    def velocity(self, now: float) -> Velocity | None:
        """Return the velocity to send to the base now; None leaves the base to other drivers."""
        seconds, self._last_time = now - self._last_time, now
        commanded = None if self.closed else self._in_control(now)
        self.silent = commanded is None
        if self.held or commanded is None:
            moved = self._velocity != NO_VELOCITY
            self._velocity = self._agent.velocity = self._person.velocity = NO_VELOCITY
            self._agent.moved &= not self.held  # a held robot moves again only after re-arming
            if moved or (self.held and self.insists and not self.closed):
                self.rest(now)
            return NO_VELOCITY if now <= self._rest_until else None
        self._velocity = self._drive.towards(commanded.velocity, self._velocity, seconds)
        self.rest(now)
        return self._velocity

    def rest(self, now: float) -> None:
        """Send zeros for a while, whenever there is nothing else to send."""
        self._rest_until = now + REST_S

    def _in_control(self, now: float) -> _Commanded | None:
        """Return the command to obey; None if all are too old."""
        for commanded in (self._person, self._agent):
            if 0.0 <= now - commanded.since <= self._timeout:
                return commanded
        return None
