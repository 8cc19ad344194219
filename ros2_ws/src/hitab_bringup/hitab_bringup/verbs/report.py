"""The verb that tells what trainings cost the person."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer

from hitab_bringup.verbs.connection import connection
from hitab_client import console
from hitab_client.command_options import AgentName, JsonPath, SwarmName

COUNTS = ("commands", "examples", "wasted", "undos", "structures", "proposals")


def register(app: typer.Typer) -> None:
    """Add this verb to the command."""
    app.command(rich_help_panel="Train")(report)


def report(
    agent: AgentName,
    automata: Annotated[
        list[str] | None,
        typer.Argument(help="Trained behaviors; default: what is being trained."),
    ] = None,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Show what trainings cost the person: time, commands, examples, and what was wasted.

    It is read from the agent's journals. Times count from step to step; pauses of more than five
    minutes are left out. Wasted examples were recorded and then deleted, undone or superseded.

    Examples:

      hitab report keeper_1

      hitab report keeper_1 ApproachBall GotoBall ControlBall Keepaway
    """
    with connection(swarm) as swarm_up:
        costs = [
            cost
            for automaton in automata or [""]
            for cost in swarm_up.agents.report(agent, automaton)
        ]
    if json != "-":
        rows = [
            (
                cost.automaton if cost.finished else f"{cost.automaton}, not saved",
                cost.began.replace("T", " ")[:16],
                f"{cost.wall_seconds / 60:.1f} min",
                f"{cost.simulated_seconds:.0f} s",
                *(str(getattr(cost, name)) for name in COUNTS),
            )
            for cost in costs
        ]
        heads = ("automaton", "began (UTC)", "time", "simulated", *COUNTS)
        console.out().print(console.table(heads, rows))
    console.write_json(json, {"trainings": list(map(asdict, costs))})
