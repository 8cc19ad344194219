"""Starts a swarm, also a temporary one, and waits until all of it answers."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
import time
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

from hitab_bringup import supervision
from hitab_bringup.libraries import read_only
from hitab_bringup.shared_memory import remove_stale
from hitab_bringup.swarm_description import SwarmDescription
from hitab_bringup.unsaved_trainings import announcements
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
from hitab_client.commands import as_command, called
from hitab_client.machine_load import busy
from hitab_client.run_folder import registry_held, running_swarms
from hitab_client.swarm_choice import way_to_stop
from hitab_core import each_once, quantity, some
from hitab_ros.conversions import remedies_of

START_SECONDS = 60.0
START_SECONDS_EACH = 0.2  # added per agent
START_SECONDS_PROCESS = 2.0  # added per process, which takes at least a second of a core
COMMANDERS_SECONDS = 10.0  # for commanders to hear all subordinates, once all nodes have reported
DOMAINS_TRIED = 3  # if the names are taken there
SENSORS_SECONDS = 1.5  # for robots to look for their sensors after they are up
VALUES_SECONDS = 2.0  # for agents to perceive, commanders the values of their subordinates
LARGE = 100  # agents; in a larger swarm a command watches only those that it needs
STRANGER_SECONDS = 1.0  # to hear who else has a name, once a process has ended because of it

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
    say: Callable[[str], None] = lambda text: None,
) -> RunRecord:
    """Start a swarm that stays up, and wait until every agent and the world answer.

    Args:
        swarm: the description.
        folder: for its files.
        progress: called as nodes come up.
        warn: called with whatever a person should know: why it is not in ROS domain 0; commanders
            that do not hear everybody yet; faults that agents have from the start; libraries that
            are read-only; trainings that they resume.
        say: called with what it does if it is interrupted, which takes a while.

    Raises:
        SwarmError: naming what did not start, or the names in use and their owner; nothing is left
            running.
    """
    refused: list[int] = []
    while True:
        try:
            return _brought_up(swarm, folder, refused, progress, warn, say)
        except NamesTakenError as error:
            refused.append(error.domain_id)
            fixed = swarm.world is None or domain_ids.chosen_by_user() is not None
            if fixed or len(refused) == DOMAINS_TRIED:
                raise
            owner = f"ROS domain {error.domain_id} is in use by {error.owner}"
            warn(f"{owner}; {swarm.name} starts in another one")


def _brought_up(
    swarm: SwarmDescription,
    folder: RunFolder,
    refused: Collection[int],
    progress: Progress | None,
    warn: Callable[[str], None],
    say: Callable[[str], None],
) -> RunRecord:
    """Do so in the first domain that is free and not refused.

    Raises:
        NamesTakenError: if it turns out not to be free.
    """
    with contextlib.ExitStack() as stack:
        with registry_held():
            supervision.refuse_running(folder)
            domain_id = domain_ids.for_swarm(refused, has_world=swarm.world is not None)
            _refuse_conflicts(swarm, folder, domain_id)
            for text in _beside_others(swarm, refused, domain_id):
                warn(text)
            remove_stale()
            record = stack.enter_context(
                _started(swarm, folder, domain_id, temporary=False, say=say)
            )
            for text in _namesakes(record, folder):
                warn(text)
        link = stack.enter_context(RosLink(domain_id))
        agents, _ = _await_all(swarm, record, folder, link, progress)
        for text in _await_commanders(swarm, record, link, progress):
            warn(text)
        for text in _slow_to_command(record):
            warn(text)
        _let_agents_perceive(link, agents, [c.name for c in swarm.commanders])
        if not record.world:
            _let_robots_hear(link, agents)
        there = sorted(agents.statuses.items())
        for text in each_once((name, text) for name, s in there for text in s.faults):
            warn(text)
        for way in dict.fromkeys(r for _, s in there for r in remedies_of(s.remedies)):
            warn(as_command(way))
        for text in read_only(folder.path):
            warn(text)
        for text in announcements(agents.statuses.values(), folder.path):
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
    swarm: SwarmDescription,
    folder: RunFolder,
    domain_id: int,
    *,
    temporary: bool,
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
        there = folder.read()
        if record is None or there is None or there.identity == record.identity:
            supervision.stop(folder)  # otherwise another swarm was started here since
        raise


def _beside_others(
    swarm: SwarmDescription, refused: Collection[int], domain_id: int
) -> Iterator[str]:
    """Yield what a person should know of swarms that are up already."""
    there = [record.swarm for _, record in running_swarms() if record.domain_id == 0]
    moved = domain_id != 0 and domain_ids.chosen_by_user() is None
    if moved and there and 0 not in refused:
        yield (
            f"ROS domain 0 has the {'swarm' if len(there) == 1 else 'swarms'} {some(there)}; "
            f"{swarm.name} starts in ROS domain {domain_id}"
        )


def _namesakes(record: RunRecord, folder: RunFolder) -> Iterator[str]:
    """Yield how to tell a swarm from others of its name that are up."""
    for other, there in running_swarms():
        if there.swarm == record.swarm and other.path != folder.path:
            yield (
                f"another {there.swarm} is up already: {there.identity}, in {other.path}; this "
                f"one is {record.identity}, and --swarm {record.identity} chooses it"
            )


def _refuse_conflicts(swarm: SwarmDescription, folder: RunFolder, domain_id: int) -> None:
    """Refuse names that a registered swarm uses."""
    for other, record in running_swarms():
        if other.path == folder.path:
            continue
        if (record.domain_id, record.namespace) != (domain_id, swarm.namespace):
            continue
        both = [name for name in swarm.agent_names if name in record.agents]
        if record.world and swarm.world is not None:
            both.append("world")
        called = "a node called" if len(both) == 1 else "nodes called"
        why = f"also has {called} {some(both)}" if both else ""
        way = _another_domain(swarm.world is None)
        if both and swarm.world is not None:
            way += ", or give it a --namespace"
        if not why and record.world and swarm.uses_sim_time:
            why = f"its world publishes the clock from which {swarm.name} takes its time"
        if why:
            raise SwarmError(
                f'swarm "{record.swarm}" is up in ROS domain {domain_id}, too, and {why}; {way}',
                way_to_stop(other, record),
            )


def _another_domain(has_drivers: bool) -> str:
    """Return the other way out if names are taken in a ROS domain."""
    if has_drivers:
        return "start it and its robots' drivers in another ROS_DOMAIN_ID"
    return "choose another ROS_DOMAIN_ID"


def _refuse_taken(record: RunRecord, agents: SwarmClient, world: WorldClient) -> None:
    """Refuse names used by any other node in the ROS domain."""
    taken = {name: agents.strangers[name] for name in record.agents if name in agents.strangers}
    if record.world and world.stranger is not None:
        taken["world"] = world.stranger
    if not taken:
        return
    other = next(iter(taken.values()))
    where = f"nodes in ROS domain {record.domain_id} that were started by hand"
    if other:
        where = f"swarm {other}, which is up in the same ROS domain {record.domain_id}"
    raise NamesTakenError(
        f"{some(list(taken))} of {record.swarm} cannot start: the names are in use by {where}; "
        f"stop these, or {_another_domain(not record.world)}",
        *(way_to_stop(*found) for found in running_swarms() if found[1].identity == other),
        domain_id=record.domain_id,
        owner=f"swarm {other}" if other else "nodes that were started by hand",
    )


def _refuse_failed(
    record: RunRecord, folder: RunFolder, agents: SwarmClient, world: WorldClient
) -> None:
    """Raise if a process has ended; an agent whose name is taken may notice it first.

    Raises:
        NamesTakenError: if names are taken.
        SwarmError: naming the process, if it has another reason.
    """
    try:
        supervision.refuse_failed(record, folder)
    except SwarmError:

        def heard() -> bool:
            return bool(agents.strangers) or world.stranger is not None

        agents.link.spin_until(heard, STRANGER_SECONDS)
        _refuse_taken(record, agents, world)
        raise


def _is_exact(swarm: SwarmDescription) -> bool:
    """Whether the world waits for its agents, so that each has to be there from the start."""
    return swarm.world is not None and swarm.world.pace == "lockstep"


def _await_all(
    swarm: SwarmDescription,
    record: RunRecord,
    folder: RunFolder,
    link: RosLink,
    progress: Progress | None,
) -> tuple[SwarmClient, WorldClient]:
    """Wait until all nodes have reported and the world hears all agents."""
    agents = SwarmClient(link, record.agents, prefix=record.namespace, identity=record.identity)
    agents.watch_all()
    world = WorldClient(
        link,
        prefix=record.namespace,
        identity=record.identity,
        started_by_it=record.world,
    )
    view = CommandView(link, record.namespace)
    # Otherwise a commander starts with the members that it knows, and the others join later.
    commanders = [c.name for c in swarm.commanders] if _is_exact(swarm) else []
    view.watch(commanders)
    total = len(record.agents) + record.world
    next_look = time.monotonic()

    def unheard() -> set[str]:
        """Return the agents that the world does not hear from yet."""
        return set(world.missing) & set(record.agents)

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
            _refuse_failed(record, folder, agents, world)
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


def _let_agents_perceive(link: RosLink, agents: SwarmClient, commanders: list[str]) -> None:
    """Give agents the time to perceive, and commanders to get their subordinates' first values.

    Only then are the faults of the others known. Commanders report until then that they lack
    these values, which is no fault of a swarm that just starts.
    """
    statuses = agents.statuses
    link.spin_until(
        lambda: all(not s.faults if n in commanders else s.perceived for n, s in statuses.items()),
        VALUES_SECONDS,
    )


def _let_robots_hear(link: RosLink, agents: SwarmClient) -> None:
    """Give robots the time to notice that sensors are missing, or to hear those that are not."""

    def has_faults() -> bool:
        return any(status.faults for status in agents.statuses.values())

    if link.spin_until(has_faults, SENSORS_SECONDS):
        link.spin_until(lambda: not has_faults(), VALUES_SECONDS)


def _slow_to_command(record: RunRecord) -> Iterator[str]:
    """Yield what to expect of commands to a large swarm.

    Each command is a process that has to find the nodes first, which takes with their number.
    """
    if len(record.agents) > LARGE:
        found = (
            f"with {quantity(len(record.agents), 'agent')}, each command takes some seconds to "
            "find those that it needs"
        )
        if much := busy():
            found += f", and minutes at first: {much}; close what else runs, such as the studio"
        yield found


def _await_commanders(
    swarm: SwarmDescription, record: RunRecord, link: RosLink, progress: Progress | None
) -> Iterator[str]:
    """Wait until all commanders hear their subordinates; yield a sentence if some do not yet.

    All nodes of the swarm have been heard here, but they discover each other one by one, which
    takes a large swarm longer. In lockstep that was waited for already.
    """
    commanders = [] if _is_exact(swarm) else [c.name for c in swarm.commanders]
    view = CommandView(link, record.namespace, record.identity)
    view.watch(commanders)

    def complete() -> bool:
        names = view.incomplete(commanders)
        if progress is not None:
            progress(len(commanders) - len(names), len(commanders), ", ".join(names[:3]))
        return not names

    if commanders and not link.spin_until(
        complete, COMMANDERS_SECONDS + START_SECONDS_EACH * len(record.agents)
    ):
        names = view.incomplete(commanders)
        yield (
            f"{some(names)} {'does' if len(names) == 1 else 'do'} not hear all subordinates yet; "
            f"`{called()} tree --commanders --watch` shows when"
        )
