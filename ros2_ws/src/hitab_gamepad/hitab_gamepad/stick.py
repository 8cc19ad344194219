"""The actions of a person, read from a joystick's messages. No ROS here.

A joystick is a radio link, a driver and cheap contacts, so nothing moves on doubtful messages: a
malformed, old or missing message counts as letting go.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from hitab_client.demonstrating import STILL, Velocity
from hitab_core import quantity
from hitab_gamepad.joystick_mapping import WAYS, Mapping
from hitab_ros.timing import AT_ONCE_S


@dataclass(frozen=True)
class StickActions:
    """The person's actions in one message.

    Attributes:
        pressed: names of the buttons that have just been pressed and count.
        down: names of the buttons that are down; none unless the switch is held.
        velocity: the wanted velocity; zeros for rest.
        trouble: why the message is ignored; empty if it counts.
    """

    pressed: tuple[str, ...] = ()
    down: frozenset[str] = frozenset()
    velocity: Velocity = STILL
    trouble: str = ""


class Stick:
    """The state of a joystick, kept from one message to the next.

    A press is the moment in which a button goes down. A button, the dead-man's switch included,
    counts only after it was seen released: a button that is down in the first message, or in the
    first one after a silence, may have been down for an hour. The emergency stop always counts,
    without the switch and in any message.

    Args:
        mapping: meaning of buttons and axes.
    """

    def __init__(self, mapping: Mapping) -> None:
        self._mapping = mapping
        self._stops = {b for b, action in mapping.actions.items() if action == "stop"}
        self._down: set[str] = {*mapping.buttons} - self._stops
        self._pressed_at: dict[str, float] = {}
        self._stamp = -math.inf
        self._heard = -math.inf

    def is_lost(self, now: float) -> bool:
        """Return whether the last message that counts is too long ago."""
        return now > self._heard + self._mapping.timeout

    def take(
        self,
        axes: Sequence[float],
        buttons: Sequence[int],
        stamp: float,
        wall: float,
        now: float,
    ) -> StickActions:
        """Take a message.

        Args:
            axes: the message's axes, each from -1 to 1.
            buttons: the message's buttons; 0 is released.
            stamp: the message's stamp, s; 0 if it has none.
            wall: present time on the clock of the stamps, s.
            now: present time on any steady clock, s.
        """
        stops = self._newly_down(self._stops, axes, buttons)
        trouble = self._trouble(axes, buttons, stamp, wall)
        if self.is_lost(now):
            self._down = {*self._mapping.buttons} - self._stops | (self._down & self._stops)
            self._pressed_at.clear()
        if trouble:
            return StickActions(tuple(stops), trouble=trouble)
        self._heard = now
        if 0.0 < stamp <= wall:
            self._stamp = stamp
        others = self._newly_down({*self._mapping.buttons} - self._stops, axes, buttons)
        hold = self._mapping.hold
        # Buttons that were down in the first message have not been pressed.
        held = hold in self._down and hold in self._pressed_at
        bounced = {b for b, at in self._pressed_at.items() if now < at + AT_ONCE_S}
        pressed = [b for b in others if held and b != hold and b not in bounced]
        for name in others:
            self._pressed_at[name] = now
        ahead, left, turn = (self._speed(way, axes) for way in WAYS)
        velocity = (ahead, left, turn) if held or hold in others else STILL
        return StickActions(
            (*stops, *pressed), frozenset(self._down) if held else frozenset(), velocity
        )

    def _newly_down(
        self, names: set[str], axes: Sequence[float], buttons: Sequence[int]
    ) -> list[str]:
        """Return which of these buttons have gone down, in the order of the mapping."""
        found = []
        for name, button in self._mapping.buttons.items():
            if name not in names:
                continue
            values: Sequence[float] = axes if button.is_axis else buttons
            if button.index >= len(values):
                continue
            value = values[button.index]
            if button.above is not None:
                down = value > button.above
            elif button.below is not None:
                down = value < button.below
            else:
                down = value != 0
            if down and name not in self._down:
                found.append(name)
            (self._down.add if down else self._down.discard)(name)
        return found

    def _trouble(
        self, axes: Sequence[float], buttons: Sequence[int], stamp: float, wall: float
    ) -> str:
        mapping = self._mapping
        for what, there, least in (
            ("button", len(buttons), mapping.buttons_min),
            ("axis", len(axes), mapping.axes_min),
        ):
            if there < least:
                plural = "axes" if what == "axis" else ""
                return (
                    f"the joystick has {quantity(there, what, plural)}, but the mapping "
                    f"{mapping.name} uses {quantity(least, what, plural)}; give the mapping of "
                    "this joystick with --mapping"
                )
        if not all(math.isfinite(axis) for axis in axes[: mapping.axes_min]):
            return "an axis of the joystick is not a number"
        if not 0.0 < stamp <= wall:
            return ""  # it does not show the age
        if wall - stamp > mapping.timeout:
            return (
                f"the joystick's messages are {wall - stamp:.1f} s old when they come; set the "
                "clocks of both computers, or check whether the network is slow"
            )
        if stamp < self._stamp and wall - self._stamp <= mapping.timeout:
            return "the joystick's messages come out of order"
        return ""

    def _speed(self, way: str, axes: Sequence[float]) -> float:
        axis = self._mapping.driving.get(way)
        if axis is None:
            return 0.0
        value = max(-1.0, min(1.0, axes[axis.index]))
        dead = self._mapping.deadzone
        # The speed begins at 0 at the edge of the dead zone, so that a robot can drive slowly.
        beyond = max(0.0, abs(value) - dead) / (1.0 - dead)
        return math.copysign(beyond, value) * axis.speed if beyond else 0.0
