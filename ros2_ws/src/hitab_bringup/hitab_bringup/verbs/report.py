"""The verb that tells what trainings cost the person."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from hitab_bringup.verbs.connection import connection
from hitab_client import console
from hitab_client.command_options import AgentName, JsonPath, SwarmName

COLUMNS = (
    "automaton",
    "began",
    "wall_seconds",
    "simulated_seconds",
    "commands",
    "examples",
    "wasted",
    "undos",
    "structures",
    "proposals",
    "finished",
)


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
    rows: list[dict[str, Any]] = []
    with connection(swarm) as swarm_up:
        for automaton in automata or [""]:
            answer = swarm_up.agents.report(agent, automaton)
            columns = zip(
                *(getattr(answer, name.replace("automaton", "automata")) for name in COLUMNS),
                strict=True,
            )
            rows += [dict(zip(COLUMNS, row, strict=True)) for row in columns]
    if json != "-":
        cells = [
            (
                row["automaton"] if row["finished"] else f"{row['automaton']}, not saved",
                row["began"].replace("T", " ")[:16],
                f"{row['wall_seconds'] / 60:.1f} min",
                f"{row['simulated_seconds']:.0f} s",
                *(str(row[name]) for name in COLUMNS[4:-1]),
            )
            for row in rows
        ]
        heads = ("automaton", "began (UTC)", "time", "simulated", *COLUMNS[4:-1])
        console.out().print(console.table(heads, cells))
    console.write_json(json, {"trainings": rows})
