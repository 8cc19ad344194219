"""The keys of a terminal as those of a demonstrator. No terminal here; keys come by name."""

from __future__ import annotations

import time
from collections.abc import Callable

from hitab_client.demonstrating.demonstrator import Demonstrator
from hitab_client.demonstrating.steering import Velocity

HOLD_S = 0.4
"""Time for which one press of an arrow key drives, s. Terminals do not tell when a key is let go;
one that is held comes again and again, about 30 times a second after a first pause."""

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
    """Hands keys to a demonstrator.

    Args:
        demonstrator: that obeys the keys.
        speed: m/s, of the arrow keys.
        turn: rad/s, of the arrow keys.
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
            demonstrator.press("stop")  # whatever else is going on
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
