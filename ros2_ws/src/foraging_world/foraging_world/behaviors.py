"""The foragers' basic behaviors: walk, turn, grip, let go. The rest is trained."""

from __future__ import annotations

from foraging_world.body import ForagerBody
from hitab_core import BasicBehavior

STEP_TURN = 0.1
"""rad in a cycle: half of the default maximum."""


def forward(body: ForagerBody) -> None:
    """Walk straight ahead, or pull if a box is held."""
    body.drive(1.0)


def stop(body: ForagerBody) -> None:
    """Stand still; keep hold of a box."""


def rotate_left(body: ForagerBody) -> None:
    """Turn to the left on the spot."""
    body.turn_by(STEP_TURN)


def rotate_right(body: ForagerBody) -> None:
    """Turn to the right on the spot."""
    body.turn_by(-STEP_TURN)


def turn_to(body: ForagerBody, place: int) -> None:
    """Turn towards X on the spot."""
    body.turn_by(body.values[place + 1])


def attach(body: ForagerBody, place: int) -> None:
    """Grip the box X, if it is in reach and nothing is held yet."""
    body.grip(body.values[place + 2])


def release(body: ForagerBody) -> None:
    """Let go of the box that is held."""
    body.let_go()


BEHAVIORS = (
    BasicBehavior("Forward", forward, description="walk ahead, or pull if a box is held"),
    BasicBehavior("Stop", stop, description="stand"),
    BasicBehavior("RotateLeft", rotate_left, description="turn to the left on the spot"),
    BasicBehavior("RotateRight", rotate_right, description="turn to the right on the spot"),
    BasicBehavior("TurnTo", turn_to, parameters=("X",), description="turn to X on the spot"),
    BasicBehavior("Attach", attach, parameters=("X",), description="grip the box X"),
    BasicBehavior("Release", release, description="let go of the box that is held"),
)
