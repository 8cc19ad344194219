"""Brings a swarm up and waits until all of it answers; brings up temporary ones too."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from hitab_bringup import domain_ids, supervision
from hitab_bringup.command_view import CommandView
from hitab_bringup.errors import SwarmError
from hitab_bringup.ros_link import RosLink
from hitab_bringup.run_folder import RunFolder, RunRecord, running_swarms
from hitab_bringup.shared_memory import remove_stale
from hitab_bringup.swarm_client import SwarmClient
from hitab_bringup.swarm_description import SwarmDescription
from hitab_bringup.world_client import WorldClient

START_SECONDS = 60.0
START_SECONDS_EACH = 0.2  # more, for each agent

Progress = Callable[[int, int, str], None]
"""Called with how many are there, how many there are to be, and who is missing."""


@dataclass
class RunningSwarm:
    """A swarm that is up, with a connection to it."""

    folder: RunFolder
    record: RunRecord
    link: RosLink
    agents: SwarmClient
    world: WorldClient


def bring_up(
    swarm: SwarmDescription, folder: RunFolder, progress: Progress | None = None
) -> RunRecord:
    """Start a swarm that stays up, and wait until every agent and the world answer.

    Raises:
        SwarmError: telling what did not start; then nothing is left running.
    """
    supervision.refuse_running(folder)
    domain_id = domain_ids.for_swarm()
    _refuse_conflicts(swarm, domain_id)
    remove_stale()
    with (
        _started(swarm, folder, domain_id, temporary=False) as record,
        RosLink(domain_id) as link,
    ):
        _await_all(swarm, record, folder, link, progress)
    return record


@contextlib.contextmanager
def temporary_swarm(
    swarm: SwarmDescription,
    run_folder: Path | None = None,
    progress: Progress | None = None,
) -> Iterator[RunningSwarm]:
    """Bring a swarm up in a ROS domain of its own, and take it down at the end.

    Args:
        swarm: the description.
        run_folder: where to keep its files; None: in a folder that is removed at the end.
        progress: told who is there.
    """
    with contextlib.ExitStack() as stack:
        if run_folder is None:
            run_folder = Path(tempfile.mkdtemp(prefix="hitab-"))
            stack.callback(shutil.rmtree, run_folder, ignore_errors=True)
        folder = RunFolder(run_folder)
        supervision.refuse_running(folder)
        domain_id = stack.enter_context(domain_ids.reserved())
        remove_stale()
        stack.callback(supervision.stop, folder)
        record = stack.enter_context(_started(swarm, folder, domain_id, temporary=True))
        link = stack.enter_context(RosLink(domain_id))
        agents, world = _await_all(swarm, record, folder, link, progress)
        yield RunningSwarm(folder, record, link, agents, world)


@contextlib.contextmanager
def _started(
    swarm: SwarmDescription, folder: RunFolder, domain_id: int, *, temporary: bool
) -> Iterator[RunRecord]:
    """Launch the processes; stop them again if what follows fails or is interrupted."""
    try:
        yield supervision.launch(swarm, folder, domain_id, temporary=temporary)
    except BaseException:
        supervision.stop(folder)
        raise


def _refuse_conflicts(swarm: SwarmDescription, domain_id: int) -> None:
    for folder, record in running_swarms():
        if record.domain_id != domain_id or record.swarm == swarm.name:
            continue
        both = sorted(set(record.agents) & set(swarm.agent_names))
        if record.world and swarm.world is not None:
            both.append("world")
        if both:
            raise SwarmError(
                f'swarm "{record.swarm}" ({folder.path}) is up in the same ROS domain '
                f"{domain_id} and has {', '.join(both)} too; choose another ROS_DOMAIN_ID, "
                f"or stop it with `hitab down {record.swarm}`"
            )


def _await_all(
    swarm: SwarmDescription,
    record: RunRecord,
    folder: RunFolder,
    link: RosLink,
    progress: Progress | None,
) -> tuple[SwarmClient, WorldClient]:
    """Wait until everybody is heard of, and until the world hears everybody."""
    agents = SwarmClient(link, record.agents)
    agents.watch_all()
    world = WorldClient(link)
    view = CommandView(link)
    # Elsewhere a commander begins with those that it knows, and the others come in later.
    exact = swarm.world is not None and swarm.world.pace == "lockstep"
    commanders = [commander.name for commander in swarm.commanders] if exact else []
    view.watch(commanders)
    total = len(record.agents) + record.world
    next_look = time.monotonic()

    def unheard() -> set[str]:
        """Return the agents that the world does not hear yet."""
        heard_of = world.status.missing if world.status is not None else ()
        return set(heard_of) & set(record.agents)

    def missing() -> list[str]:
        names = [name for name in record.agents if name not in agents.statuses]
        names += view.incomplete(commanders) if not names else []
        if record.world and (world.status is None or unheard()):
            names.append("world")
        return names

    def complete() -> bool:
        nonlocal next_look
        names = missing()
        if progress is not None:
            progress(total - len(names), total, ", ".join(names[:3]))
        if names and time.monotonic() >= next_look:
            supervision.refuse_failed(record, folder)
            next_look = time.monotonic() + 0.3
        return not names

    allowed = START_SECONDS + START_SECONDS_EACH * total
    if not link.spin_until(complete, allowed):
        names = missing()
        lines = "\n".join(f"  | {line}" for line in folder.tail(names[0]))
        raise SwarmError(
            f"{', '.join(names)} did not answer within {allowed:g} s; the end of "
            f"{folder.log(names[0])}:\n{lines}"
        )
    return agents, world
