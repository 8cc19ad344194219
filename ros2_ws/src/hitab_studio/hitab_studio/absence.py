"""How an agent, or the world, is absent: one word for each state, as on the command line."""

from __future__ import annotations

import time
from dataclasses import dataclass

from hitab_client.run_processes import Silence
from hitab_ros import names
from hitab_studio.known import Known

NOT_HEARD = "not heard yet"


@dataclass(frozen=True)
class Absence:
    """How somebody is absent.

    Attributes:
        word: for where there is no more room; the same everywhere.
        what: the rest of a sentence that begins with the name, such as ``has ended``.
    """

    word: str
    what: str

    def __str__(self) -> str:
        return self.what


def absence(known: Known, name: str) -> Absence | None:
    """Return how an agent, or the world, is absent; None if it answers."""
    if name != names.WORLD and name not in known.agents:
        return Absence("not up", "is not up")
    since = known.silent.get(name, known.gone.get(name))
    was_heard = name == names.WORLD or name in known.statuses
    if since is None and was_heard:
        return None
    if (why := known.why.get(name)) is not None:
        return _by_process(why, name)
    if since is not None:
        return Absence("silent", f"has been silent for {time.monotonic() - since:.0f} s")
    if known.is_waiting:
        return Absence(NOT_HEARD, "has not been heard yet")
    return Absence("no answer", "does not answer")


def _by_process(why: Silence, name: str) -> Absence:
    if why.process == name:
        return Absence(why.state, why.what)
    return Absence(why.state, f"does not answer: {why.process}, which runs it, {why.what}")
