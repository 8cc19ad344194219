"""Starts a swarm, also a temporary one, and waits until all of it answers."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from hitab_bringup import supervision
from hitab_bringup.shared_memory import remove_stale
from hitab_bringup.swarm_description import SwarmDescription
from hitab_client import (
    CommandView,
    NamesTakenError,
    RosLink,
    RunFolder,
    RunRecord,
    SwarmClient,
    SwarmError,
    WorldClient,
    domain_ids,
)
from hitab_client.run_folder import registry_held, running_swarms
from hitab_core import each_once, some

START_SECONDS = 60.0
START_SECONDS_EACH = 0.2  # added per agent
START_SECONDS_PROCESS = 2.0  # added per process, which takes at least a second of a core
DOMAINS_TRIED = 3  # by a temporary swarm, which may use any

Progress = Callable[[int, int, str], None]
"""Called with the number of nodes that are up, the expected number and the missing names."""


@dataclass
class RunningSwarm:
    """A swarm that is up, with a connection to it."""

    folder: RunFolder
    record: RunRecord
    link: RosLink
    agents: SwarmClient
    world: WorldClient


def bring_up(
    swarm: SwarmDescription,
    folder: RunFolder,
    progress: Progress | None = None,
    warn: Callable[[str], None] = lambda text: None,
) -> RunRecord:
    """Start a swarm that stays up, and wait until every agent and the world answer.

    Args:
        swarm: the description.
        folder: for its files.
        progress: called as nodes come up.
        warn: called with each fault that agents have from the start.

    Raises:
        SwarmError: naming what did not start, or the names in use and their owner; nothing is left
            running.
    """
    with contextlib.ExitStack() as stack:
        with registry_held():
            supervision.refuse_running(folder)
            domain_id = domain_ids.for_swarm()
            _refuse_conflicts(swarm, folder, domain_id)
            remove_stale()
            record = stack.enter_context(_started(swarm, folder, domain_id, temporary=False))
        link = stack.enter_context(RosLink(domain_id))
        agents, _ = _await_all(swarm, record, folder, link, progress)
        there = sorted(agents.statuses.items())
        for text in each_once((name, fault) for name, s in there for fault in s.faults):
            warn(text)
    return record


@contextlib.contextmanager
def temporary_swarm(
    swarm: SwarmDescription,
    run_folder: Path | None = None,
    progress: Progress | None = None,
) -> Iterator[RunningSwarm]:
    """Start a swarm in its own ROS domain and stop it at the end.

    Args:
        swarm: the description.
        run_folder: for its files; None: a folder that is removed at the end.
        progress: called as nodes come up.
    """
    with contextlib.ExitStack() as stack:
        if run_folder is None:
            run_folder = Path(tempfile.mkdtemp(prefix="hitab-"))
            stack.callback(shutil.rmtree, run_folder, ignore_errors=True)
        folder = RunFolder(run_folder)
        supervision.refuse_running(folder)
        remove_stale()
        for tries_left in reversed(range(DOMAINS_TRIED)):
            # Reserved to the end, so that another try uses another domain.
            domain_id = stack.enter_context(domain_ids.reserved())
            attempt = stack.enter_context(contextlib.ExitStack())
            attempt.callback(supervision.stop, folder)
            try:
                record = attempt.enter_context(_started(swarm, folder, domain_id, temporary=True))
                link = attempt.enter_context(RosLink(domain_id))
                agents, world = _await_all(swarm, record, folder, link, progress)
                break
            except NamesTakenError:  # by nodes that outlived the process that reserved the domain
                if not tries_left:
                    raise
                attempt.close()
        yield RunningSwarm(folder, record, link, agents, world)


@contextlib.contextmanager
def _started(
    swarm: SwarmDescription, folder: RunFolder, domain_id: int, *, temporary: bool
) -> Iterator[RunRecord]:
    """Launch the processes; stop them again if the context fails or is interrupted."""
    record = None
    try:
        record = supervision.launch(swarm, folder, domain_id, temporary=temporary)
        yield record
    except BaseException:
        there = folder.read()
        if record is None or there is None or there.identity == record.identity:
            supervision.stop(folder)  # otherwise another swarm was started here since
        raise


def _refuse_conflicts(swarm: SwarmDescription, folder: RunFolder, domain_id: int) -> None:
    """Refuse names that a registered swarm uses."""
    for other, record in running_swarms():
        if record.domain_id != domain_id or other.path == folder.path:
            continue
        both = [name for name in swarm.agent_names if name in record.agents]
        if record.world and swarm.world is not None:
            both.append("world")
        if both:
            raise SwarmError(
                f'swarm "{record.swarm}" is up in the same ROS domain {domain_id} and also has '
                f"{some(both)} ({other.path}); stop it with "
                f"`hitab down --run-dir {other.path}`, or choose another ROS_DOMAIN_ID"
            )


def _refuse_taken(record: RunRecord, agents: SwarmClient, world: WorldClient) -> None:
    """Refuse names used by any other node in the ROS domain."""
    taken = {name: agents.strangers[name] for name in record.agents if name in agents.strangers}
    if record.world and world.stranger is not None:
        taken["world"] = world.stranger
    if not taken:
        return
    other = next(iter(taken.values()))
    where = f"nodes in ROS domain {record.domain_id} that were started by hand"
    stop = "stop them"
    if other:
        where = f"swarm {other}, which is up in the same ROS domain {record.domain_id}"
        stop = "stop it with `hitab down` where it was started"
        for there, registered in running_swarms():
            if registered.identity == other:
                where += f" ({there.path})"
                stop = f"stop it with `hitab down --run-dir {there.path}`"
    raise NamesTakenError(
        f"{some(list(taken))} of {record.swarm} cannot start: the names are in use by {where}; "
        f"{stop}, or choose another ROS_DOMAIN_ID"
    )


def _await_all(
    swarm: SwarmDescription,
    record: RunRecord,
    folder: RunFolder,
    link: RosLink,
    progress: Progress | None,
) -> tuple[SwarmClient, WorldClient]:
    """Wait until all nodes have reported and the world hears all agents."""
    agents = SwarmClient(link, record.agents, identity=record.identity)
    agents.watch_all()
    world = WorldClient(link, identity=record.identity, started_by_it=record.world)
    view = CommandView(link)
    # Otherwise a commander starts with the members that it knows, and the others join later.
    exact = swarm.world is not None and swarm.world.pace == "lockstep"
    commanders = [commander.name for commander in swarm.commanders] if exact else []
    view.watch(commanders)
    total = len(record.agents) + record.world
    next_look = time.monotonic()

    def unheard() -> set[str]:
        """Return the agents that the world does not hear from yet."""
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
        _refuse_taken(record, agents, world)
        names = missing()
        if progress is not None:
            progress(total - len(names), total, ", ".join(names[:3]))
        if names and time.monotonic() >= next_look:
            supervision.refuse_failed(record, folder)
            next_look = time.monotonic() + 0.3
        return not names

    running = len({member.process for member in swarm.members})
    allowed = START_SECONDS + START_SECONDS_EACH * total + START_SECONDS_PROCESS * running
    if not link.spin_until(complete, allowed):
        names = missing()
        lines = "\n".join(f"  | {line}" for line in folder.tail(names[0]))
        raise SwarmError(
            f"{some(names)} did not answer within {allowed:g} s; the end of "
            f"{folder.log(names[0])}:\n{lines}"
        )
    return agents, world
