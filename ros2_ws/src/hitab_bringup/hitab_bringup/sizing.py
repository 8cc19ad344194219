"""Prediction of what a swarm takes on this machine, from trial runs of parts of it."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import psutil  # type: ignore[import-untyped]
from hitab_msgs.msg import WorldStatus

from hitab_bringup.libraries.run_libraries import copy_library
from hitab_bringup.processes.bringing_up import Progress, await_up, temporary_processes
from hitab_bringup.processes.swarm_processes import ALL_ENDPOINTS_MAX, library_of
from hitab_bringup.swarm_files.swarm_description import SwarmDescription
from hitab_client import DescriptionError, RosLink, RunFolder, RunRecord, SwarmError
from hitab_client.runs.run_processes import process_states
from hitab_core import Fix, some
from hitab_ros import names, qos
from hitab_ros.names import WORLD
from hitab_ros.timing import FOUND_S, HEARTBEAT_S, START_S

WHOLE_MAX = 60
"""Number of members up to which a swarm is tried as a whole."""

TRIAL_MIN, TRIAL_MAX = 30, 1000
"""Numbers of members of trial runs."""

BUSY = 0.1
"""Share of the cores from which other programs disturb a trial."""


@dataclass(frozen=True)
class Needs:
    """What a swarm takes, or is predicted to take.

    Attributes:
        start_s: duration of `hitab up`, s.
        start_cpu_s: CPU time of all processes and of `hitab up` until then, s.
        cycle_ms: duration of a cycle, ms; in lockstep as short as the machine allows.
        world_cores, agents_cores: cores that play the swarm: of the world, of all others.
        world_mb, agents_mb: memory of the world and of all others, MB.
        strangers_cores: cores that other programs used meanwhile.
    """

    start_s: float
    start_cpu_s: float
    cycle_ms: float
    world_cores: float
    agents_cores: float
    world_mb: float
    agents_mb: float
    strangers_cores: float


def trial_sizes(members: int) -> tuple[int, ...]:
    """Return how many agents and commanders of a swarm to run in each trial."""
    if members <= WHOLE_MAX:
        return (members,)
    large = min(max(members // 4, 2 * TRIAL_MIN), TRIAL_MAX)
    return max(large // 8, TRIAL_MIN), large


def predict(trials: Mapping[int, Needs], members: int, parallel: int) -> Needs:
    """Return the needs of a swarm from those of one or two trials.

    Each need is a constant, of the world and the processes, and a share of each member. What other
    programs use makes a start longer, but its CPU time hardly; so the latter tells its growth.

    Args:
        trials: needs by the number of members.
        members: number of members of the swarm.
        parallel: number of processes that run at the same time.
    """
    small, large = min(trials), max(trials)
    few, many = trials[small], trials[large]
    if small == large:
        return many

    def at_size(name: str) -> float:
        first, last = getattr(few, name), getattr(many, name)
        # A swarm takes no less than a part of it, though noise may say so.
        return float(max(last, last + (last - first) * (members - large) / (large - small)))

    linear = {field.name: at_size(field.name) for field in fields(Needs)}
    added_s = (linear["start_cpu_s"] - many.start_cpu_s) / parallel
    strangers_cores = max(few.strangers_cores, many.strangers_cores)
    linear |= {"start_s": many.start_s + added_s, "strangers_cores": strangers_cores}
    return Needs(**linear)


def refuse_untriable(swarm: SwarmDescription) -> None:
    """Check that trial runs move nothing but a simulated world.

    Raises:
        DescriptionError: if the swarm has no world, or starts programs of its own.
    """
    instead = "start it with `hitab up`, and see its processes in `top`"
    if swarm.world is None:
        raise DescriptionError(
            f'{swarm.file}: swarm "{swarm.name}" has no `world:`, so a trial run would move '
            f"robots; {instead}"
        )
    if swarm.processes:
        programs = some([process.name for process in swarm.processes])
        raise DescriptionError(
            f'{swarm.file}: swarm "{swarm.name}" starts programs of its own ({programs}), which a '
            f"trial run must not; leave out `processes:`, or {instead}"
        )


def reduced(swarm: SwarmDescription, share: float) -> SwarmDescription:
    """Return a swarm with a share of its members, in the whole world.

    Squads stay whole, and hosts stay as many: each keeps the first squads in the order of the
    command tree, so that they share their superiors.
    """
    inside = Counter(member.process for member in swarm.members)
    place_of: dict[str, str] = {}
    places: dict[str, dict[str, list[str]]] = {}
    for agent in swarm.agents:
        squad = agent.superior or agent.name
        alone = inside[agent.process] == 1
        place = place_of.setdefault(squad, "" if alone else agent.process)
        places.setdefault(place, {}).setdefault(squad, []).append(agent.name)
    kept: set[str] = set()
    for squads in places.values():
        # A host of one agent would be a process of another kind.
        wanted = left = max(2, math.ceil(share * sum(map(len, squads.values()))))
        for together in squads.values():
            if left > 0:
                kept.update(together[: max(wanted, TRIAL_MIN)])
                left -= len(together)
    superiors = {member.name: member.superior for member in swarm.members}
    for name in list(kept):
        while (name := superiors[name]) and name not in kept:
            kept.add(name)
    all_endpoints = swarm.all_endpoints
    if all_endpoints is None:
        all_endpoints = len(swarm.members) <= ALL_ENDPOINTS_MAX
    return replace(
        swarm,
        agents=tuple(agent for agent in swarm.agents if agent.name in kept),
        commanders=tuple(
            replace(one, subordinates={n: r for n, r in one.subordinates.items() if n in kept})
            for one in swarm.commanders
            if one.name in kept
        ),
        all_endpoints=all_endpoints,
    )


def try_out(
    swarm: SwarmDescription, folder: Path, seconds: float, progress: Progress | None = None
) -> Needs:
    """Run a swarm for a while and measure what it takes; nothing of it is left.

    Args:
        swarm: the description.
        folder: run folder of the swarm, whose libraries are copied.
        seconds: how long to measure the swarm while it plays, s.
        progress: called as nodes come up.
    """
    with TemporaryDirectory(prefix="hitab-size-") as text:
        place = Path(text)
        swarm = _with_copies(swarm.with_world(paused=False), folder, place)
        began, own = time.monotonic(), time.process_time()
        with temporary_processes(swarm, place / "run") as (run, record):
            await_up(swarm, record, run, progress)
            start_s, own = time.monotonic() - began, time.process_time() - own
            start_cpu_s = own + _cpu(run.processes())
            return Needs(start_s, start_cpu_s, *_playing(run, record, seconds))


def _with_copies(swarm: SwarmDescription, folder: Path, place: Path) -> SwarmDescription:
    """Return a swarm whose agents share copies of their libraries as they share the libraries."""
    copies: dict[Path, Path] = {}

    def own(member: Any) -> Any:
        library = library_of(member, folder)
        copy = copies.setdefault(library, place / "libraries" / str(len(copies)))
        return replace(member, library=copy)

    agents, commanders = tuple(map(own, swarm.agents)), tuple(map(own, swarm.commanders))
    for library, copy in copies.items():
        if library.is_dir():
            copy_library(library, copy)
    return replace(swarm, agents=agents, commanders=commanders)


def _playing(run: RunFolder, record: RunRecord, seconds: float) -> Iterator[float]:
    """Yield the needs of a swarm that plays, from `cycle_ms` on."""
    pids = {state["name"]: state["pid"] for state in process_states(record)}
    world = [psutil.Process(pids[WORLD])]
    others = [process for process in run.processes() if process not in world]
    with RosLink(record.domain_id) as link:
        came: list[tuple[float, ...]] = []

        def take(status: WorldStatus) -> None:
            if came and time.monotonic() - came[-1][0] < HEARTBEAT_S:
                return  # published because it changed
            all_ = psutil.cpu_times()
            used = _cpu(world), _cpu(others)
            strangers = all_.user + all_.nice + all_.system - time.process_time() - sum(used)
            came.append((time.monotonic(), status.cycle, *used, strangers))

        topic = names.of_world(names.STATUS, record.namespace)
        link.subscribe(WorldStatus, topic, take, qos.LATCHED)
        link.spin_until(lambda: len(came) > 1 and came[-1][1] > came[-2][1], START_S)
        link.spin_until(lambda: False, FOUND_S)  # discovery of this node ends, the game begins
        came.clear()
        link.spin_until(
            lambda: len(came) > 1 and came[-1][0] - came[0][0] > seconds, seconds + START_S
        )
    if len(came) < 2:
        raise SwarmError(f"the world of {record.swarm} does not report", Fix.DOCTOR())
    each = [[b - a for a, b in zip(*two, strict=True)] for two in pairwise(came)]
    # The median leaves out seconds in which the machine was busy with something else.
    cycles, *cores = (median(d[i] / d[0] for d in each) for i in range(1, 5))
    *own, strangers = cores
    yield 1000 / cycles if cycles else math.inf
    yield from own
    yield from (sum(p.memory_full_info().pss for p in of) / 1e6 for of in (world, others))
    yield max(0.0, strangers)


def _cpu(processes: Sequence[psutil.Process]) -> float:
    """Return the CPU time of processes so far, s."""
    return sum(sum(process.cpu_times()[:2]) for process in processes)


def lacks(swarm: SwarmDescription, needs: Needs, cores: int, memory_mb: float) -> Iterator[str]:
    """Yield what a machine lacks for a swarm, each with ways out.

    Args:
        swarm: the description.
        needs: needs of the swarm.
        cores: number of cores.
        memory_mb: available memory, MB.
    """
    used, memory = needs.world_cores + needs.agents_cores, needs.world_mb + needs.agents_mb
    ways = "use more machines or fewer agents"
    if swarm.world is not None and swarm.world.pace == "realtime":
        factor = swarm.world.factor * min(1.0, cores / used, 1.0 / needs.world_cores)
        slower = f"give the world a `factor` below {factor:.2g}, or {ways}"
        if used > cores:
            yield f"it takes {used:.1f} cores, and there are {cores}: {slower}"
        elif needs.world_cores > 1.0:
            yield f"the world, one process, takes {needs.world_cores:.1f} cores: {slower}"
    if needs.strangers_cores > BUSY * cores:
        yield (
            f"other programs used {needs.strangers_cores:.1f} of {cores} cores meanwhile, which "
            "makes everything slower: repeat it on an idle machine"
        )
    if memory > memory_mb:
        yield f"it takes {memory:,.0f} MB, and {memory_mb:,.0f} MB are available: {ways}"
