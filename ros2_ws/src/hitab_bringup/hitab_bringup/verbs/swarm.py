"""Verbs for whole swarms: up, down."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from hitab_client import completion, console
from hitab_client.command_options import SwarmName
from hitab_core import quantity

PANEL = "Swarm"
RunDir = Annotated[
    Path | None,
    typer.Option("--run-dir", help="Folder for its files, instead of the default one."),
]


def register(app: typer.Typer) -> None:
    """Add these verbs to the command."""
    app.command(rich_help_panel=PANEL)(up)
    app.command(rich_help_panel=PANEL)(down)


def up(
    swarm: Annotated[
        str,
        typer.Argument(
            help="A swarm description, or the name of a shipped one.",
            autocompletion=completion.swarm_descriptions,
        ),
    ] = "keepaway",
    pace: Annotated[
        str, typer.Option(help="lockstep or realtime; overrides the description.")
    ] = "",
    paused: Annotated[bool, typer.Option("--paused", help="Start with the world paused.")] = False,
    library: Annotated[
        str | None,
        typer.Option(
            "--library",
            "-l",
            metavar="LIBRARY",
            help="A folder, or SWARM/LIBRARY of a swarm that was up, for all agents to use and to "
            "save to. Default: folders of their own, which are kept for the next start.",
            show_default=False,
        ),
    ] = None,
    run_dir: RunDir = None,
) -> None:
    """Start a swarm and keep it alive until `hitab down`.

    Waits until every agent and the world answer. Killed processes are restarted. What the agents
    learn is kept: the next start of the swarm goes on with it.

    Examples:

      hitab up keepaway

      hitab up keepaway --library my_library

      hitab up my_swarm.yaml --pace lockstep --paused
    """
    from hitab_bringup.bringing_up import bring_up
    from hitab_bringup.library_choice import with_library
    from hitab_bringup.swarm_description import PACES
    from hitab_bringup.swarm_file import read_swarm
    from hitab_client import RunFolder
    from hitab_client.shipped import find_file

    description = read_swarm(find_file(swarm, "swarms", "swarm"))
    if pace and pace not in PACES:
        raise typer.BadParameter(f'"{pace}" is not one of {", ".join(PACES)}')
    if pace:
        description = description.with_world(pace=pace)
    if paused:
        description = description.with_world(paused=True)
    if library:
        description = with_library(description, library)
    folder = RunFolder.of_swarm(description.name, run_dir)
    began = time.monotonic()
    faults: list[str] = []
    with console.progress(f"starting {description.name}") as advance:
        record = bring_up(description, folder, advance, faults.append)
    console.say(
        f"{record.swarm} is up: {quantity(len(record.agents), 'agent')}"
        f"{' and a world' if record.world else ''} in ROS domain {record.domain_id} "
        f"({time.monotonic() - began:.1f} s)"
    )
    console.say(f"files in {folder.path}; look with `hitab status`, stop with `hitab down`")
    for fault in faults:
        console.note(fault)


def down(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[SWARM]",
            help="The swarm, if several are up.",
            autocompletion=completion.swarms,
        ),
    ] = None,
    swarm: SwarmName = None,
    run_dir: RunDir = None,
) -> None:
    """Stop a swarm and all its processes.

    Examples:

      hitab down

      hitab down keepaway

      hitab down --run-dir my_run
    """
    from hitab_bringup.supervision import stop
    from hitab_client import RunFolder
    from hitab_client.run_folder import registry_held
    from hitab_client.swarm_choice import to_take_down

    if run_dir is not None:
        folder = RunFolder(run_dir)
        record = folder.read()
    else:
        found = to_take_down(name or swarm)
        if found is None:
            console.say("no swarm is up")
            return
        folder, record = found
    with console.err().status("stopping"), registry_held():
        killed = stop(folder)
    console.say(f"{record.swarm if record else folder.path.name} is down")
    if killed:
        console.note(f"killed {quantity(len(killed), 'process', 'processes')} that did not stop")
