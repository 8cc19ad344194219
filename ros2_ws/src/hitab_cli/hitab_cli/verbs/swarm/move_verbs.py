"""Verb that moves agents to another machine: move."""

from __future__ import annotations

from typing import Annotated

import typer

from hitab_cli.verbs.verb_connection import connection
from hitab_client import completion, console
from hitab_client.terminal.cli_options import SwarmName
from hitab_core import quantity


def move(
    group: Annotated[str, typer.Argument(autocompletion=completion.agents)],
    to: Annotated[str, typer.Option("--to", metavar="MACHINE")],
    swarm: SwarmName = None,
) -> None:
    """Move agents to another machine of the swarm, with what they have learned.

    Whole processes are moved. If their machine is lost, what the agents have learned comes from
    the other machine's copy. When the lost machine is back, it leaves the agents to the new one.

    Args:
        group: An agent, a line of agents, a commander with all below it, a process, or a machine.
        to: The machine to move them to.

    Examples:
      hitab move squad_2 --to lab_1
      hitab move lab_2 --to lab_1
    """
    from hitab_machines import move as move_to
    from hitab_machines import processes_meant

    with connection(swarm) as swarm_up:
        machines = swarm_up.need_machines()
        machines.listen()
        processes = processes_meant(group, machines)
        with console.progress(f"moving to {to}", "processes") as advance:
            moves = move_to(processes, to, machines, advance)
    for one in moves:
        if one.message:
            console.say(one.message)
        for text in one.lost:
            console.note(f"{one.process}: {text}")
    if failed := [one for one in moves if one.error]:
        for one in failed:
            console.error(one.error)
        console.note(f"{quantity(len(failed), 'process', 'processes')} not moved")
        raise typer.Exit(1)
