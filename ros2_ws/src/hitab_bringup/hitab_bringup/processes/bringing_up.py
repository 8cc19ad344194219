"""Start of a swarm, also a temporary one, up to the answers of all nodes."""

from __future__ import annotations

import contextlib
import itertools
import re
import shutil
import tempfile
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from hitab_msgs.msg import WorldState

from hitab_bringup.libraries.run_libraries import read_only
from hitab_bringup.libraries.unsaved_trainings import announcements
from hitab_bringup.processes import supervision
from hitab_bringup.processes.leases import as_leased
from hitab_bringup.swarm_files.swarm_description import SwarmDescription
from hitab_bringup.swarm_files.swarm_file import parameter_places
from hitab_client import (
    CommanderView,
    DescriptionError,
    NamesTakenError,
    RosLink,
    RunFolder,
    RunRecord,
    SwarmClient,
    SwarmError,
    WorldClient,
    domain_ids,
)
from hitab_client.runs.run_folder import registry_held, running_swarms
from hitab_client.runs.run_processes import RunProcesses
from hitab_client.runs.swarm_choice import way_to_stop
from hitab_client.terminal.cli_remedies import called, with_commands
from hitab_core import Fix, each_once, some
from hitab_ros.names import WORLD
from hitab_ros.timing import ANSWER_S, DISCOVERY_EACH_S, POLL_S, PROMPT_S, SETTLE_S, START_S

DOMAINS_TRIED = 3  # maximum number, if names are taken

Progress = Callable[[int, int, str], None]
"""Called with the number of nodes that are up, the expected number and the missing names."""


@dataclass
class RunningSwarm:
    """A swarm that is up, with a connection to it.

    Attributes:
        groups: reports of the commanders on their groups, by name.
    """

    folder: RunFolder
    record: RunRecord
    link: RosLink
    agents: SwarmClient
    world: WorldClient
    groups: CommanderView


def bring_up(
    swarm: SwarmDescription,
    folder: RunFolder,
    progress: Progress | None = None,
    warn: Callable[[str], None] = lambda text: None,
    say: Callable[[str], None] = lambda text: None,
) -> RunRecord:
    """Start a swarm that stays up, and wait until every agent and the world answer.

    Of a swarm on several machines, this is the part on the chosen machine.

    Args:
        swarm: the description.
        folder: run folder.
        progress: called as nodes come up.
        warn: called with notes for people: ROS domains in use; commanders that have not heard
            from all subordinates; initial faults; read-only libraries; resumed trainings.
        say: called with the reason when an interruption takes a while.

    Raises:
        SwarmError: if the start fails; names the failed processes, or the names in use and their
            owner. No process is left running.
    """
    swarm = as_leased(swarm, folder.path)
    refused: list[int] = []
    is_free = swarm.world is not None and not swarm.machine  # to choose a ROS domain
    while True:
        with contextlib.ExitStack() as stack:
            try:
                with registry_held():
                    supervision.refuse_running(folder)
                    domain_id = domain_ids.for_swarm(refused, is_free=is_free)
                    _refuse_conflicts(swarm, folder, domain_id)
                    record = stack.enter_context(_started(swarm, folder, domain_id, say=say))
                await_up(swarm, record, folder, progress, warn)
                return record
            except NamesTakenError as error:
                refused.append(error.domain_id)
                fixed = not is_free or domain_ids.chosen_by_user() is not None
                if fixed or len(refused) == DOMAINS_TRIED:
                    raise
                owner = f"ROS domain {error.domain_id} is in use by {error.owner}"
                warn(f"{owner}; {swarm.name} starts in another one")


def await_up(
    swarm: SwarmDescription,
    record: RunRecord,
    folder: RunFolder,
    progress: Progress | None = None,
    warn: Callable[[str], None] = lambda text: None,
) -> None:
    """Wait until every agent and the world answer and perceive; see `bring_up`."""
    with _answering(swarm, record, folder, progress) as running:
        for text in _to_know(swarm, running, progress):
            warn(text)


@contextlib.contextmanager
def temporary_swarm(
    swarm: SwarmDescription, run_folder: Path | None = None, progress: Progress | None = None
) -> Iterator[RunningSwarm]:
    """Start a swarm in its own ROS domain and stop it at the end.

    Args:
        swarm: the description.
        run_folder: run folder; None for a folder that is removed at the end.
        progress: called as nodes come up.
    """
    with (
        temporary_processes(swarm, run_folder) as (folder, record),
        _answering(swarm, record, folder, progress) as running,
    ):
        yield running


@contextlib.contextmanager
def temporary_processes(
    swarm: SwarmDescription, run_folder: Path | None = None
) -> Iterator[tuple[RunFolder, RunRecord]]:
    """Start a swarm's processes in their own ROS domain, and stop them at the end.

    Args:
        swarm: the description.
        run_folder: run folder; None for a folder that is removed at the end.
    """
    with contextlib.ExitStack() as stack:
        if run_folder is None:
            run_folder = Path(tempfile.mkdtemp(prefix="hitab-"))
            stack.callback(shutil.rmtree, run_folder, ignore_errors=True)
        folder = RunFolder(run_folder)
        supervision.refuse_running(folder)
        domain_id = stack.enter_context(domain_ids.reserved())
        stack.callback(supervision.stop, folder)
        yield folder, stack.enter_context(_started(swarm, folder, domain_id, temporary=True))


@contextlib.contextmanager
def _started(
    swarm: SwarmDescription,
    folder: RunFolder,
    domain_id: int,
    *,
    temporary: bool = False,
    say: Callable[[str], None] = lambda text: None,
) -> Iterator[RunRecord]:
    """Launch the processes; stop them again if the context fails or is interrupted."""
    record = None
    try:
        record = supervision.launch(swarm, folder, domain_id, temporary=temporary)
        yield record
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            say(f"interrupted: stopping what was started of {swarm.name} …")
        current = folder.read()
        if record is None or current is None or current.identity == record.identity:
            supervision.stop(folder)  # otherwise another swarm has been started here since
        raise


# -- names that are taken -----------------------------------------------------------------------


def _refuse_conflicts(swarm: SwarmDescription, folder: RunFolder, domain_id: int) -> None:
    """Refuse names that a registered swarm uses."""
    for other, record in running_swarms():
        here = (record.domain_id, record.namespace) == (domain_id, swarm.namespace)
        if other.path == folder.path or not here:
            continue
        both = [member.name for member in swarm.members_here if member.name in record.agents_here]
        if record.world_here and swarm.world is not None and swarm.runs(WORLD):
            both.append("world")
        why = ""
        if both:
            why = f"also has {'a node' if len(both) == 1 else 'nodes'} called {some(both)}"
        elif record.world and swarm.uses_sim_time:
            why = f"its world publishes the clock from which {swarm.name} takes its time"
        if why:
            namespace = ", or give it a --namespace" if both and swarm.world is not None else ""
            raise SwarmError(
                f'swarm "{record.swarm}" is up in the same ROS domain {domain_id} and {why}; '
                f"{_another_domain(swarm.world is None)}{namespace}",
                way_to_stop(other, record),
            )


def _another_domain(has_drivers: bool) -> str:
    """Return the way out of taken names that uses another ROS domain."""
    if has_drivers:
        return "start it and its robots' drivers in another ROS_DOMAIN_ID"
    return "choose another ROS_DOMAIN_ID"


def _refuse_taken(record: RunRecord, agents: SwarmClient, world: WorldClient) -> None:
    """Refuse names that any other node in the ROS domain uses."""
    taken = agents.strangers | (world.strangers if record.world_here else {})
    if not taken:
        return
    other = next(iter(taken.values()))
    owner = f"swarm {other}" if other else "nodes that were started by hand"
    raise NamesTakenError(
        f"{some(list(taken))} of {record.swarm} cannot start: the names are in use by {owner} in "
        f"ROS domain {record.domain_id}; stop that, or {_another_domain(not record.world)}",
        *(way_to_stop(*found) for found in running_swarms() if found[1].identity == other),
        domain_id=record.domain_id,
        owner=owner,
    )


# -- waiting ------------------------------------------------------------------------------------


@contextlib.contextmanager
def _answering(
    swarm: SwarmDescription, record: RunRecord, folder: RunFolder, progress: Progress | None
) -> Iterator[RunningSwarm]:
    """Wait until all nodes have reported and the world hears all agents; yield a connection."""
    prefix, identity = record.namespace, record.identity
    with RosLink(record.domain_id) as link:
        agents = SwarmClient(
            link,
            record.agents_here,
            prefix=prefix,
            identity=identity,
            processes=RunProcesses(record),
        )
        if agents.is_large:
            agents.watch_all()
        world = WorldClient(link, prefix=prefix, identity=identity, started_by_it=record.world)
        view = CommanderView(agents)
        view.watch(_commanders_here(swarm))
        # Otherwise a commander starts with its known members, and the others join later.
        groups = view.incomplete if _is_exact(swarm) else {}
        starting = RunningSwarm(folder, record, link, agents, world, view)
        total = len(record.agents_here) + record.world_here
        next_look = time.monotonic()

        def missing() -> Collection[str]:
            if names := agents.unheard or groups:
                return names
            status = world.status
            lacks = status is None or not agents.expected.keys().isdisjoint(status.missing)
            return ("world",) if record.world_here and lacks else ()

        def complete() -> bool:
            nonlocal next_look
            _refuse_taken(record, agents, world)
            names = missing()
            if progress is not None:
                _show(progress, names, total)
            if names and time.monotonic() >= next_look:
                _refuse_failed(swarm.file, starting)
                next_look = time.monotonic() + POLL_S
            return not names

        running = len({member.process for member in swarm.members_here})
        allowed = START_S + 10 * DISCOVERY_EACH_S * total + PROMPT_S * running
        if not link.spin_until(complete, allowed):
            names = list(missing())
            lines = "\n".join(f"  | {line}" for line in folder.tail(names[0]))
            raise SwarmError(
                f"{some(names)} did not answer within {allowed:g} s; the end of "
                f"{folder.log(names[0])}:\n{lines}",
                Fix.DOCTOR(),
            )
        yield starting


def _commanders_here(swarm: SwarmDescription) -> list[str]:
    """Return the commanders here with all their subordinates; the others wait for machines."""
    here = {member.name for member in swarm.members_here}
    return [c.name for c in swarm.commanders if {c.name, *c.subordinates} <= here]


def _show(progress: Progress, missing: Collection[str], total: int) -> None:
    progress(total - len(missing), total, ", ".join(itertools.islice(missing, 3)))


def _is_exact(swarm: SwarmDescription) -> bool:
    """Whether the world waits for its agents, so that all agents have to be up from the start."""
    return swarm.world is not None and swarm.world.pace == "lockstep"


def _refuse_failed(file: Path, swarm: RunningSwarm) -> None:
    """Check that no process has ended; an agent may be the first to detect a taken name.

    Raises:
        NamesTakenError: if names are in use.
        SwarmError: if a process has ended for another reason; names the process.
        DescriptionError: if a line of the swarm file is the reason; names the line.
    """
    try:
        supervision.refuse_failed(swarm.record, swarm.folder)
    except SwarmError as error:
        agents, world = swarm.agents, swarm.world
        swarm.link.spin_until(lambda: bool(agents.strangers or world.strangers), SETTLE_S)
        _refuse_taken(swarm.record, agents, world)
        wrong = re.search(r'the parameter "([\w.]+)" is ', str(error))
        if wrong is None or not (places := parameter_places(file, wrong[1])):
            raise
        raise DescriptionError(f"{', '.join(places)}: {error}") from error


# -- notes for people ---------------------------------------------------------------------------


def _to_know(
    swarm: SwarmDescription, running: RunningSwarm, progress: Progress | None
) -> Iterator[str]:
    """Yield notes for people about a swarm that has just started."""
    record, folder, agents = running.record, running.folder, running.agents
    if not _is_exact(swarm):  # in lockstep, the start has waited for that already
        yield from _await_commanders(running, progress)
    _let_agents_perceive(running.link, agents, record.commanders)
    if not record.world:
        _let_robots_hear(running.link, agents)
    statuses = sorted(agents.statuses.items())
    yield from each_once((name, text) for name, s in statuses for text in s.faults)
    yield from read_only(folder.path)
    world = running.world.status
    begins_paused = swarm.world is not None and swarm.world.paused
    if world is not None and world.mode == WorldState.PAUSED and not begins_paused:
        yield with_commands("the world is still paused, as it was before", [Fix.RESUME_WORLD()])
    yield from announcements(agents.statuses.values(), folder.path, record.commanders)


def _let_agents_perceive(link: RosLink, agents: SwarmClient, commanders: Sequence[str]) -> None:
    """Wait for the agents' first percepts, and for commanders to get values from subordinates.

    Only then are the faults of agents known. Until then commanders report these values as missing,
    which is not a fault in a swarm that has just started.
    """
    waiting = list(agents.statuses)
    groups = {*commanders}

    def all_perceive() -> bool:
        while waiting and (status := agents.statuses.get(waiting[-1])) is not None:
            if status.faults if waiting[-1] in groups else not status.perceived:
                return False
            waiting.pop()
        return not waiting

    link.spin_until(all_perceive, PROMPT_S)


def _let_robots_hear(link: RosLink, agents: SwarmClient) -> None:
    """Wait for robots to receive sensor data, or to detect missing sensors."""
    if link.spin_until(lambda: bool(agents.faulty), SETTLE_S):
        link.spin_until(lambda: not agents.faulty, PROMPT_S)


def _await_commanders(running: RunningSwarm, progress: Progress | None) -> Iterator[str]:
    """Wait until all commanders hear their subordinates; yield a sentence if some do not.

    This process has heard all nodes, but the nodes discover each other one by one, which takes
    longer in a large swarm.
    """
    commanders, missing = running.record.commanders, running.groups.incomplete

    def complete() -> bool:
        if progress is not None:
            _show(progress, missing, len(commanders))
        return not missing

    allowed = ANSWER_S + 10 * DISCOVERY_EACH_S * len(running.record.agents)
    if commanders and not running.link.spin_until(complete, allowed):
        names = list(missing)
        yield (
            f"{some(names)} {'does' if len(names) == 1 else 'do'} not hear all subordinates yet; "
            f"`{called()} tree --commanders --watch` shows when"
        )
