"""Completion of names in the shell, from the run registry, without ROS."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from hitab_client.runs.run_folder import RunRecord


def agents(context: typer.Context, incomplete: str) -> list[str]:
    """Return the agents of the swarm that is up."""
    return begun(incomplete, (name for record in _records(context) for name in record.agents))


def commanders(context: typer.Context, incomplete: str) -> list[str]:
    """Return the commanders of the swarm that is up."""
    return begun(incomplete, (name for record in _records(context) for name in record.commanders))


def processes(context: typer.Context, incomplete: str) -> list[str]:
    """Return the processes that have a log: agents, hosts, the world and the supervisor."""
    names = (n for r in _records(context) for n in (*r.processes, *r.agents, "supervisor"))
    return begun(incomplete, names)


def swarms(incomplete: str) -> list[str]:
    """Return the swarms that are up."""
    from hitab_client.runs.run_folder import running_swarms

    return begun(incomplete, (record.swarm for _, record in running_swarms()))


def swarm_descriptions(incomplete: str) -> list[str]:
    """Return the shipped swarms."""
    return begun(incomplete, _shipped("swarms"))


def lessons(incomplete: str) -> list[str]:
    """Return the shipped lessons."""
    return begun(incomplete, _shipped("lessons"))


def _shipped(folder: str) -> list[str]:
    from hitab_client.runs.shipped import shipped_names

    return shipped_names(folder)


def begun(incomplete: str, names: Iterable[str]) -> list[str]:
    """Return the names that begin with a text."""
    return sorted({name for name in names if name.startswith(incomplete)})


def _records(context: typer.Context) -> Iterator[RunRecord]:
    """Yield the records of the chosen swarm, or of all that are up."""
    from hitab_client.runs.run_folder import running_swarms
    from hitab_client.runs.swarm_choice import meant

    which = context.params.get("swarm")
    with contextlib.suppress(OSError):
        for _, record in meant(which, running_swarms()) if which else running_swarms():
            yield record
