"""Absence of agents, the world and machines, in the same words as on the command line."""

from __future__ import annotations

import time
from dataclasses import replace

from hitab_client.runs.run_processes import Silence
from hitab_client.terminal.cli_remedies import called
from hitab_core import natural
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
    machine = known.machine_of.get(name, "")
    if (last := known.machines.get(machine)) is not None:
        what = f"does not answer: {machine}, which runs it, {_silent_for(last)}"
        return Silence(machine, what, lasts=True)
    if since is not None:
        return Silence(name, _silent_for(since), lasts=False)
    if known.is_waiting:
        return Silence(name, "has not been heard yet", lasts=False, state=NOT_HEARD)
    return Silence(name, "does not answer", lasts=False, state="no answer")


def silent_machines(known: SwarmState) -> dict[str, str]:
    """Return how long each silent machine has been silent and the way out, by its name."""
    silent = {name: since for name, since in known.machines.items() if since is not None}
    others = sorted(known.machines.keys() - silent.keys(), key=natural)
    found = {}
    for name in sorted(silent, key=natural):
        found[name] = _silent_for(silent[name])
        if others and name in known.machine_of.values():
            move = f"`{called()} move {name} --to {others[0]}`"
            found[name] += f"; {move} starts its agents there"
    return found


def _silent_for(since: float) -> str:
    return f"has been silent for {time.monotonic() - since:.0f} s"
