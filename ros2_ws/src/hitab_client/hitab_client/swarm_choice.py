"""Chooses among the swarms that are up."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hitab_client.errors import SwarmError
from hitab_client.run_folder import (
    Found,
    RunFolder,
    RunRecord,
    registered_swarms,
    running_swarms,
    state_home,
)
from hitab_core import has

if TYPE_CHECKING:
    from hitab_client.ros_link import RosLink

LOOK_SECONDS = 3.0
"""How long to look for a swarm that the registry does not know."""


def only(found: Sequence[Found], where: str = "") -> Found | None:
    """Return the only swarm of several; None if there is none.

    Raises:
        SwarmError: if there are several, with their distinct names.
    """
    if len(found) > 1:
        names = [record.swarm for _, record in found]
        if len(set(names)) < len(names):
            names = [record.identity or str(folder.path) for folder, record in found]
        raise SwarmError(
            f"several swarms are up{where} {has(names)}; choose one with --swarm NAME"
        )
    return found[0] if found else None


def meant(which: str, among: Iterable[Found]) -> list[Found]:
    """Return the swarms that match a name, an identity or a run folder."""
    path = Path(which).resolve() if os.sep in which or which.startswith(".") else None
    return [
        (folder, record)
        for folder, record in among
        if which in (record.swarm, record.identity) or folder.path == path
    ]


def folder_called(which: str) -> RunFolder:
    """Return the run folder at a path, or the default one of a swarm with a name."""
    return RunFolder(Path(which) if os.sep in which else state_home() / which)


def find_running(which: str | None) -> Found | None:
    """Return the named swarm, or the only one that is up; None if none is up.

    Args:
        which: its name, identity or run folder; None: the only one.

    Raises:
        SwarmError: if several are up and none is named, or the named one is not.
    """
    up = list(running_swarms())
    if which is None:
        return only(up)
    if os.sep in which:
        folder = RunFolder(Path(which))
        record = folder.read()  # temporary ones too
        if record is not None and folder.supervisor(record) is not None:
            return folder, record
    found = only(meant(which, up))
    if found is None:
        names = has(record.swarm for _, record in up)
        raise SwarmError(f'no swarm "{which}" is up {names}; start it with `hitab up`')
    return found


def find_meant(which: str | None, domain_id: int | None) -> Found | None:
    """Return the swarm to connect to; see `find_running`.

    Args:
        which: its name, identity or run folder; None: the only one.
        domain_id: ROS domain of the swarm, if none is named; None: any.

    Raises:
        SwarmError: if several are up and none is named, or the named one is not.
    """
    if which is not None or domain_id is None:
        return find_running(which)
    there = [found for found in running_swarms() if found[1].domain_id == domain_id]
    return only(there, f" in ROS domain {domain_id}")


def none_is_up(domain_id: int | None) -> str:
    """Return a text for when `find_meant` found none: what the registry knows, what comes next."""
    where = f"under {state_home()}" if domain_id is None else f"in ROS domain {domain_id}"
    known = [f"No swarm runs {where}."]
    for folder, record in registered_swarms():
        if folder.supervisor(record) is None:
            known.append(f'"{record.swarm}" has ended without `hitab down`: {folder.path}.')
        else:
            known.append(
                f'"{record.swarm}" runs in ROS domain {record.domain_id}; '
                f"choose it with --swarm {record.swarm}, or unset ROS_DOMAIN_ID."
            )
    known.append(f"Looking for {LOOK_SECONDS:g} s for one that was started elsewhere ...")
    return " ".join(known)


def reported_on(link: RosLink) -> Iterator[str]:
    """Yield the topics on which agents and worlds report their status."""
    from hitab_ros import names

    for kind in names.STATUS_TYPES:
        for topic in link.topics_of_type(kind):
            if link.node.count_publishers(topic):
                yield topic


def look_elsewhere(link: RosLink) -> None:
    """Look for nodes of a swarm that was started by hand, or on another computer.

    Raises:
        SwarmError: if there are none.
    """
    if not link.spin_until(lambda: any(reported_on(link)), LOOK_SECONDS):
        raise SwarmError("no swarm is up; start one with `hitab up keepaway`")


def to_take_down(which: str | None) -> tuple[RunFolder, RunRecord | None] | None:
    """Return the swarm to take down: a running one, else what a crashed one left behind.

    Raises:
        SwarmError: if the choice is ambiguous, or the named swarm is missing.
    """
    up = list(running_swarms())
    left = [found for found in registered_swarms() if found[0].supervisor(found[1]) is None]
    if which is None:
        return only(up) or only(left)
    found = only(meant(which, up)) or only(meant(which, left))
    if found is not None:
        return found
    folder = folder_called(which)
    record = folder.read()
    if record is not None or folder.processes():
        return folder, record
    return find_running(which)
