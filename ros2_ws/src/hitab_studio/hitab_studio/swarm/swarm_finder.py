"""Finds the swarm to connect to, which may start, end or be replaced at any time."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from hitab_client import RunFolder
from hitab_client.connecting.domain_ids import chosen_by_user
from hitab_client.connecting.identity import STARTED_BY_HAND, is_identity
from hitab_client.runs.run_folder import Found, running_swarms
from hitab_client.runs.swarm_choice import is_namespace, meant
from hitab_client.terminal.cli_remedies import called


@dataclass(frozen=True)
class SwarmTarget:
    """A swarm to connect to, or just a ROS domain that may contain one.

    Attributes:
        domain_id: ROS domain.
        swarm: name of the swarm; "" if unknown.
        identity: identity of the present start; `STARTED_BY_HAND` for nodes that no `hitab up` has
            started; "" for any node.
        world: whether `hitab up` has started a world.
        namespace: namespace of all nodes; "" if none.
        folder: run folder of the swarm; "" if started elsewhere.
        agents: names of the expected agents.
        start: time of the start, s since the epoch; 0 if unknown.
        problem: reason for which there is no swarm to connect to; "" if there is one.
        choices: the swarms that a person may choose, including this one if found in a run folder.
    """

    domain_id: int
    swarm: str = ""
    agents: tuple[str, ...] = ()
    start: float = 0.0
    problem: str = ""
    identity: str = ""
    world: bool = False
    namespace: str = ""
    folder: str = ""
    choices: tuple[SwarmTarget, ...] = field(default=(), compare=False)


class Finder:
    """Finds the swarm to connect to, and keeps it while it is up.

    A swarm that was started elsewhere (another HITAB_HOME, user or computer) is found only by its
    identity, as on the command line.

    Args:
        swarm: name, identity, namespace or run folder; None for the running or chosen one.
        run_folder: run folder of a swarm that may be missing from the list of running swarms.
    """

    def __init__(self, swarm: str | None = None, run_folder: Path | None = None) -> None:
        is_path = swarm is not None and os.sep in swarm and not is_namespace(swarm)
        self._folder = Path(swarm) if is_path and swarm else run_folder
        self._swarm = None if is_path else swarm
        self._kept = ""
        self._kept_name = ""

    def choose(self, folder: str) -> None:
        """Switch to the swarm in this run folder."""
        self._kept = folder

    def __call__(self) -> SwarmTarget:
        """Return the swarm to connect to now."""
        own = chosen_by_user()
        if self._folder is not None:
            folder = RunFolder(self._folder)
            record = folder.read()
            if record is None or folder.supervisor(record) is None:
                return SwarmTarget(own or 0, problem=_none_in(folder))
            return _target((folder, record))
        up = [*running_swarms()]
        if self._swarm is not None:
            up = meant(self._swarm, up)
        elif own is not None:
            up = [found for found in up if found[1].domain_id == own]
        if up:
            return self._one_of(up, own or 0)
        self._kept = ""
        if self._swarm is None or is_namespace(self._swarm):
            space = (self._swarm or "").rstrip("/")
            return SwarmTarget(own or 0, identity=STARTED_BY_HAND, namespace=space)
        if is_identity(self._swarm):
            return SwarmTarget(own or 0, self._swarm, identity=self._swarm)
        return SwarmTarget(own or 0, self._swarm, problem=f'Swarm "{self._swarm}" is not up.')

    def _one_of(self, up: Sequence[Found], domain_id: int) -> SwarmTarget:
        """Return the kept swarm, or the only one; a problem if a person has to choose.

        A kept swarm that has ended is not replaced by another one, since it may be restarted.
        """
        shown = next((found for found in up if str(found[0].path) == self._kept), None)
        if shown is None and len(up) == 1 and (self._swarm is not None or not self._kept):
            shown = up[0]
        choices = tuple(map(_target, up))
        if shown is not None:
            self._kept, self._kept_name = str(shown[0].path), shown[1].swarm
            return replace(_target(shown), choices=choices)
        ended = f"{self._kept_name} has ended. " if self._kept else ""
        several = "Several swarms are up" if len(up) > 1 else "Another swarm is up"
        text = f"{ended}{several}. Choose the one to show:"
        return SwarmTarget(domain_id, self._swarm or "", problem=text, choices=choices)


def _none_in(folder: RunFolder) -> str:
    path = folder.path
    return f"No swarm is up in {path}. `{called()} up SWARM --run-dir {path}` starts one there."


def _target(found: Found) -> SwarmTarget:
    folder, record = found
    return SwarmTarget(
        record.domain_id,
        record.swarm,
        record.agents,
        folder.started.timestamp() if folder.started is not None else 0.0,
        identity=record.identity,
        world=record.world,
        namespace=record.namespace,
        folder=str(folder.path),
    )
