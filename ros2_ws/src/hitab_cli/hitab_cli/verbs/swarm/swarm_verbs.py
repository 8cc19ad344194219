"""Verbs for whole swarms: up, down."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from hitab_client import completion, console
from hitab_client.terminal.cli_options import SwarmName
from hitab_client.terminal.cli_remedies import called, with_commands
from hitab_core import VOCABULARY_NAME, Fix, HitabError, has, quantity

if TYPE_CHECKING:
    from hitab_bringup import SwarmDescription
    from hitab_client import RunFolder, RunRecord
    from hitab_machines import RemoteStarts

LARGE = 100
"""Number of agents above which lines of progress are printed, if there is no bar."""


def up(
    swarm: Annotated[
        str, typer.Argument(autocompletion=completion.swarm_descriptions)
    ] = "keepaway",
    pace: Literal["lockstep", "realtime"] | None = None,
    paused: Annotated[bool, typer.Option("--paused")] = False,
    library: Annotated[str | None, typer.Option("--library", "-l", metavar="LIBRARY")] = None,
    namespace: Annotated[str, typer.Option(metavar="NAME")] = "",
    use_sim_time: Annotated[bool, typer.Option("--use-sim-time")] = False,
    run_dir: Path | None = None,
    agents: Annotated[int, typer.Option(min=0)] = 0,
    machine: Annotated[str, typer.Option(metavar="NAME")] = "",
    every: Annotated[bool, typer.Option("--all")] = False,
) -> None:
    """Start a swarm and keep it alive until `hitab down`.

    Waits until every agent and the world answer. Killed processes are restarted. Learned behaviors
    are kept for the next start of the swarm. A world that was paused when the swarm went down
    stays paused.

    Of a swarm on several machines, --machine starts the part of this one. Without a file here, the
    swarm's name suffices: another machine that is up sends its file.

    Args:
        swarm: A swarm description, the name of a shipped one, or a Python file with a world.
        pace: lockstep or realtime; overrides the description.
        paused: Start with the world paused.
        library: A folder, or SWARM/LIBRARY of a swarm that was up, for all agents to use and to
            save to. Default: a folder per agent, which is kept for the next start. An unsaved
            training resumes at the next start with the same library.
        namespace: Namespace around all nodes, so that another swarm with the same agents can be
            up in the same ROS domain. The swarm is then called SWARM_NAME.
        use_sim_time: All nodes but the world take their time from the world's clock.
        run_dir: Run folder, instead of the default one.
        agents: Number of agents, in a world in a Python file. 0: as in the file.
        machine: This machine's name under `machines:`.
        every: Start all machines of the swarm: this one is the one without `ssh:`, and the others
            are started by ssh.

    Examples:
      hitab up keepaway
      hitab up keepaway --library my_library
      hitab up my_swarm.yaml --pace lockstep --paused
      hitab up keepaway --namespace left
      hitab up my_swarm.yaml --machine lab_1
      hitab up my_swarm --machine lab_2
      hitab up my_swarm.yaml --all
    """
    from hitab_bringup import bring_up, described_swarm
    from hitab_client import RunFolder
    from hitab_client.runs.run_folder import running_swarms
    from hitab_client.runs.swarm_choice import name_to_choose

    if machine and not every:
        swarm = _file_or_sent(swarm, namespace, run_dir)
    description = described_swarm(
        swarm,
        run_dir,
        namespace=namespace,
        use_sim_time=use_sim_time,
        pace=pace or "",
        paused=paused,
        library=library or "",
        agents=agents,
        machine=None if every else machine,
    )
    if library:
        for new in {member.library for member in description.members}:
            if new is not None and not new.is_dir():
                console.note(f"{new} is a new library: nothing is learned in it yet")
    folder = RunFolder.of_swarm(description.name, run_dir)
    began = time.monotonic()
    faults: list[str] = []
    failures: list[str] = []
    with contextlib.ExitStack() as stack:
        starts = None
        if every:
            settings = {"--namespace": namespace, "--pace": pace}
            options = [
                part for option in settings.items() if option[1] for part in map(str, option)
            ]
            options += ["--use-sim-time"] * use_sim_time + ["--paused"] * paused
            description, starts = _all_machines(description, machine, namespace, options)
        if description.machine:
            _refuse_to_join(description, folder)
        if starts is not None:
            stack.enter_context(starts)
        nodes = len(description.members_here)
        tenth = nodes // 10 if nodes > LARGE else 0
        with console.progress(f"starting {description.name}", "nodes", line_every=tenth) as bar:
            record = bring_up(description, folder, bar, faults.append, console.note)
        if starts is not None:
            failures += starts.wait()
        if record.machine:
            faults += _others(description, record)
    where = f"{record.machine} of {record.swarm}" if record.machine else record.swarm
    console.say(
        f"{where} is up: {quantity(len(record.agents_here), 'agent')}"
        f"{' and a world' if record.world_here else ''} in ROS domain {record.domain_id} "
        f"({time.monotonic() - began:.1f} s)"
    )
    look, stop = "status", "down"
    if len(list(running_swarms())) > 1:
        name = name_to_choose(record)
        look, stop = f"status --swarm {name}", f"down {name}"
    ways = f"look with `{called()} {look}`, stop with `{called()} {stop}`"
    console.say(f"files in {folder.path}; {ways}")
    for fault in faults:
        console.note(fault)
    if failures:
        raise HitabError("\n".join(failures))


def _file_or_sent(swarm: str, namespace: str, run_dir: Path | None) -> str:
    """Return the path of a swarm file here, or of the one that another machine sends by its name.

    Shipped swarms run on one machine, so a name without a file is that of a swarm that is up.
    """
    from hitab_bringup.processes import supervision
    from hitab_client import RunFolder
    from hitab_machines import fetch_description, refuse_limits

    if Path(swarm).is_file() or VOCABULARY_NAME.match(swarm) is None:
        return swarm
    name = "_".join((swarm, *filter(None, namespace.split("/"))))
    folder = RunFolder.of_swarm(name, run_dir)
    supervision.refuse_running(folder)
    refuse_limits(name)
    return str(fetch_description(name, folder.path, console.note))


def _all_machines(
    description: SwarmDescription, machine: str, namespace: str, options: Sequence[str]
) -> tuple[SwarmDescription, RemoteStarts]:
    """Return the swarm on this machine, and the starts of the others."""
    from hitab_client import domain_ids
    from hitab_machines import RemoteStarts, local_machine

    here = description.on_machine(machine or local_machine(description))
    name = here.name.removesuffix("".join(f"_{part}" for part in namespace.split("/") if part))
    domain_id = domain_ids.for_swarm(is_free=False)
    return here, RemoteStarts(here, name, domain_id, options, console.say)


def _refuse_to_join(description: SwarmDescription, folder: RunFolder) -> None:
    from hitab_bringup.processes import supervision
    from hitab_machines import refuse_to_join

    supervision.refuse_running(folder)
    with console.err().status("looking for the other machines"):
        refuse_to_join(description)


def _others(description: SwarmDescription, record: RunRecord) -> list[str]:
    """Wait a while for the other machines; return what to say about them."""
    from hitab_machines import await_machines

    with console.progress("waiting for the other machines", "machines") as advance:
        return list(await_machines(description, record, advance))


def down(
    name: Annotated[
        str | None, typer.Argument(metavar="swarm", autocompletion=completion.swarms)
    ] = None,
    swarm: SwarmName = None,
    run_dir: Annotated[Path | None, typer.Option("--run-dir")] = None,
    every: Annotated[bool, typer.Option("--all")] = False,
    machine: Annotated[str, typer.Option(metavar="NAME")] = "",
) -> None:
    """Stop a swarm and all its processes, on all of its machines.

    Unsaved trainings are listed and kept: the next start of the swarm resumes them.

    Args:
        name: The swarm, if several are up: its name, identity, namespace or run folder.
        run_dir: Run folder of the swarm, instead of a name.
        every: Stop all swarms in this state folder.
        machine: Stop only the part on this machine.

    Examples:
      hitab down
      hitab down keepaway
      hitab down --all
      hitab down --run-dir my_run
    """
    from hitab_client import RunFolder
    from hitab_client.runs.run_folder import registered_swarms
    from hitab_client.runs.swarm_choice import to_take_down

    if every and (name or swarm or run_dir):
        raise typer.BadParameter(
            "it stops every swarm; leave out the name, --swarm and --run-dir", param_hint="--all"
        )
    found: list[tuple[RunFolder, RunRecord | None]]
    if every:
        found = list(registered_swarms())
    elif run_dir is not None:
        folder = RunFolder(run_dir)
        found = [(folder, folder.read())]
    else:
        one = to_take_down(name or swarm)
        found = [one] if one is not None else []
    if not found:
        console.say("no swarm is up")
    for folder, record in found:
        complete = True
        if record is not None and record.machines and folder.supervisor(record) is not None:
            complete = _take_down_machines(record, machine)
        if machine in ("", record.machine if record is not None else ""):
            _take_down(folder, record)
        if not complete:
            raise typer.Exit(1)


def _take_down_machines(record: RunRecord, only: str) -> bool:
    """Stop a swarm on its other machines, or on one; return whether all have answered.

    Raises:
        SwarmError: if there is no machine of this name.
    """
    from hitab_client import RosLink, SwarmError
    from hitab_machines import SwarmMachines

    if only not in ("", *record.machines):
        raise SwarmError(f'no machine "{only}" {has(record.machines, only)}')
    others = [name for name in record.machines if only in ("", name) and name != record.machine]
    failed = []
    with RosLink(record.domain_id) as link:
        machines = SwarmMachines(link, record)
        machines.listen()
        for name in others:
            try:
                if name in machines.silent():
                    raise SwarmError(f"{name} is not heard, so nothing was stopped there")
                machines.take_down(name)
                console.say(f"{name} is down")
            except SwarmError as error:
                failed.append(name)
                console.error(error)
    for name in failed:
        console.note(
            f"if the swarm still runs on {name}, stop it there: `{called()} down --machine {name}`"
        )
    return not failed


def _take_down(folder: RunFolder, record: RunRecord | None) -> None:
    from hitab_bringup import left_to_resume
    from hitab_bringup.processes import supervision
    from hitab_client.runs.run_folder import registry_held
    from hitab_client.runs.swarm_choice import name_to_choose

    name = name_to_choose(record) if record else folder.path.name
    try:
        with console.err().status("stopping"), registry_held():
            killed = supervision.stop(folder)
    except KeyboardInterrupt:
        again = [Fix.DOWN_FOLDER(folder=folder.path)]
        console.note(with_commands(f"{name} may be ending all the same", again))
        raise
    console.say(f"{name} is down")
    if killed:
        console.note(f"killed {quantity(len(killed), 'process', 'processes')} that did not stop")
    for text in left_to_resume(folder.path):
        console.note(text)
