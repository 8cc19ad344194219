"""The states of absence of an agent or the world, in the same words as on the command line."""

from __future__ import annotations

import time
from dataclasses import replace

from hitab_client.runs.run_processes import Silence
from hitab_ros import names
from hitab_studio.swarm.swarm_state import SwarmState

NOT_HEARD = "not heard yet"


def absence(known: SwarmState, name: str) -> Silence | None:
    """Return the state of absence of an agent or the world; None if present.

    `Silence.what` completes a sentence that begins with the name, such as ``has ended``.
    """
    if name != names.WORLD and name not in known.members:
        return Silence(name, "is not up", lasts=True, state="not up")
    since = known.silent.get(name)
    was_heard = name == names.WORLD or name in known.statuses
    if since is None and was_heard:
        return None
    if (why := known.why.get(name)) is not None:
        whose = f"does not answer: {why.process}, which runs it, {why.what}"
        return why if why.process == name else replace(why, what=whose)
    if since is not None:
        what = f"has been silent for {time.monotonic() - since:.0f} s"
        return Silence(name, what, lasts=False)
    if known.is_waiting:
        return Silence(name, "has not been heard yet", lasts=False, state=NOT_HEARD)
    return Silence(name, "does not answer", lasts=False, state="no answer")
