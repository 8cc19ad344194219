"""Context managers that change how a world runs, and always restore it."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

from hitab_msgs.msg import WorldState, WorldStatus
from hitab_msgs.srv import Control, Snapshot

from hitab_client.errors import SwarmError
from hitab_client.terminal.interruptions import not_interrupted
from hitab_client.world_client import WorldClient
from hitab_core import Fix

ARRANGED = "as_arranged"
"""Name of the snapshot that restores a world's arrangement."""


@contextlib.contextmanager
def as_it_was(world: WorldClient) -> Iterator[WorldStatus]:
    """Restore a world's pace, factor and mode at the end.

    Errors and Ctrl-C, even together, do not prevent this; only the world itself can.

    Raises:
        SwarmError: if there is no world, or if restoring fails without another error.
    """
    before = world.wait()
    try:
        yield before
    except BaseException:
        _restore(world, before)  # the first error is the one to report
        raise
    problem = _restore(world, before)
    if problem is not None:
        raise SwarmError(
            f"the world could not be restored to {before.mode} in {before.pace}: {problem}",
            Fix.STATUS(),
            Fix.PACE(),
            Fix.RESUME_WORLD(),
        ) from problem


@contextlib.contextmanager
def standing_still(world: WorldClient | None) -> Iterator[WorldStatus | None]:
    """Pause a world and set it to lockstep at full speed; restore it at the end.

    Args:
        world: client of the world; None to do nothing.

    Raises:
        SwarmError: as in `as_it_was`.
    """
    if world is None:
        yield None
        return
    with as_it_was(world) as before:
        world.control(Control.Request.PACE, pace="lockstep")
        world.state_at(0)
        world.shown(world.control(Control.Request.PAUSE))
        yield before


@contextlib.contextmanager
def arranged_as_it_was(world: WorldClient) -> Iterator[None]:
    """Restore the arrangement of a paused world at the end, and stop its episodes.

    Raises:
        SwarmError: if the world can keep no more snapshots.
    """
    requests, seed = Snapshot.Request, world.wait().seed
    world.snapshot(requests.SAVE, ARRANGED)
    try:
        yield
    except BaseException:
        _do_all(lambda: world.play(0, seed))  # without a limit, or the rest would be played
        raise
    finally:
        _do_all(
            lambda: world.shown(world.control(Control.Request.PAUSE)),
            lambda: world.shown(world.snapshot(requests.RESTORE, ARRANGED)),
            lambda: world.snapshot(requests.DELETE, ARRANGED),
        )


def _restore(world: WorldClient, before: WorldStatus) -> Exception | None:
    """Restore as much as possible; return the first error."""
    if not world.is_there():
        return SwarmError("it is gone")
    requests, paused = Control.Request, before.mode == WorldState.PAUSED
    return _do_all(
        lambda: world.control(requests.PACE, pace=before.pace, factor=before.factor),
        lambda: world.control(requests.PAUSE if paused else requests.RESUME),
    )


def _do_all(*steps: Callable[[], Any]) -> Exception | None:
    """Run each step even if an earlier one fails; return the first error."""
    problems: list[Exception] = []
    with not_interrupted():
        for step in steps:
            try:
                step()
            except Exception as error:
                problems.append(error)
    return problems[0] if problems else None
