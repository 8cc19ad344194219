"""Keyboard input for a demonstrator, by names of keys; independent of any terminal."""

from __future__ import annotations

import time
from collections.abc import Callable

from hitab_client.demonstrating.demonstrator import Demonstrator
from hitab_client.demonstrating.steering import Velocity

HOLD_S = 0.4
"""Driving time of one press of an arrow key, s. Terminals do not report released keys; a held key
repeats about 30 times a second after a first pause."""

ACTION_KEYS = {
    "t": "test",
    "u": "undo",
    "y": "redo",
    "b": "earlier",
    ".": "nothing",
    "S": "save",
    "[": "previous",
    "]": "next",
    " ": "stop",
    "G": "go",
    "R": "arm",
}
"""Keys of actions; the studio uses the same ones."""

AHEAD, LEFT, TURN = range(3)
ARROW_AXES = {
    "up": (AHEAD, 1.0),
    "down": (AHEAD, -1.0),
    "left": (TURN, 1.0),
    "right": (TURN, -1.0),
    "shift-left": (LEFT, 1.0),
    "shift-right": (LEFT, -1.0),
}
"""Component of the velocity, and its sign, by arrow key."""


class KeyboardInput:
    """Passes keys to a demonstrator.

    Args:
        demonstrator: receiver of the keys.
        speed: speed of the arrow keys, m/s.
        turn: turn rate of the arrow keys, rad/s.
        clock: s; any steady clock.
    """

    def __init__(
        self,
        demonstrator: Demonstrator,
        speed: float,
        turn: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._demonstrator = demonstrator
        self._speeds: Velocity = (speed, speed, turn)
        self._clock = clock
        self._arrows: dict[int, tuple[float, float]] = {}

    def press(self, key: str) -> None:
        """Take a key: a character, or the name of an arrow key such as ``shift-left``."""
        demonstrator = self._demonstrator
        if ACTION_KEYS.get(key) == "stop":
            demonstrator.press("stop")  # also while a prompt waits
        elif demonstrator.prompt is not None:
            demonstrator.answer(key)
        elif key in ARROW_AXES:
            self._drive(*ARROW_AXES[key])
        elif key in ACTION_KEYS:
            demonstrator.press(ACTION_KEYS[key])
        elif behavior := demonstrator.words.on_key(key):
            demonstrator.press_behavior(behavior)
        elif key.isprintable():
            demonstrator.tell(f'nothing is on the key "{key}"; ? shows all keys', failed=True)

    def _drive(self, way: int, sense: float) -> None:
        now = self._clock()
        self._arrows[way] = sense * self._speeds[way], now + HOLD_S
        ahead, left, turn = (
            value if until >= now else 0.0
            for value, until in (self._arrows.get(w, (0.0, now)) for w in (AHEAD, LEFT, TURN))
        )
        self._demonstrator.steer((ahead, left, turn), HOLD_S)
