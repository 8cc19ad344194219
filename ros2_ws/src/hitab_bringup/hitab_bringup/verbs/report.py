"""The verb that shows what trainings took the person who gave them."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from hitab_bringup.verbs.connection import connection
from hitab_client import console
from hitab_client.command_options import AgentName, JsonPath, SwarmName

if TYPE_CHECKING:
    from hitab_client import SwarmClient

MINUTES_FROM_S = 120.0
"""From here on times are shown in minutes."""

COUNTS = ("commands", "examples", "wasted", "undos", "structures", "proposals")


def register(app: typer.Typer) -> None:
    """Add this verb to the command."""
    app.command(rich_help_panel="Train")(report)


def report(
    agent: AgentName = "",
    automata: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="behaviors", help="Trained behaviors. Default: what is being trained."
        ),
    ] = None,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Show what your trainings took: time, commands, examples, and what was wasted.

    Without a name, it shows the trainings that are under way. It is read from the journals of the
    agents.

    `time` and `simulated` count from step to step, by the clock and in the world, without pauses
    of more than five minutes and the time while the swarm was down. `commands` and `undos` are
    what you did. `examples` counts those that there were in the end, as `hitab examples` lists
    them. `wasted` counts those that were recorded and not learned from: they were deleted or
    undone, or are listed as superseded, since a command in the same place contradicts them.
    `structures` counts the sets of features that were tried: 1, and one more for each `hitab
    examples features`. `proposals` counts the questions of the agent that you answered as it
    proposed.

    Examples:

      hitab report

      hitab report keeper_1

      hitab report keeper_1 ApproachBall GotoBall ControlBall Keepaway
    """
    with connection(swarm) as swarm_up:
        costs = [
            (name, cost)
            for name in ([agent] if agent else _in_training(swarm_up.agents))
            for automaton in automata or [""]
            for cost in swarm_up.agents.report(name, automaton)
        ]
    several = len({name for name, _ in costs}) > 1
    if json != "-":
        rows = [
            (
                *([name] if several else []),
                cost.automaton if cost.finished else f"{cost.automaton}, not saved",
                cost.began.replace("T", " ")[:16],
                _duration(cost.wall_seconds),
                _duration(cost.simulated_seconds),
                *(str(getattr(cost, count)) for count in COUNTS),
            )
            for name, cost in costs
        ]
        heads = (
            *(["agent"] if several else []),
            "automaton",
            "began (UTC)",
            "time",
            "simulated",
            *COUNTS,
        )
        console.out().print(console.table(heads, rows))
    console.write_json(json, {"trainings": [{"agent": n, **asdict(cost)} for n, cost in costs]})


def _duration(seconds: float) -> str:
    """Return a time as a person would say it."""
    return f"{seconds:.0f} s" if seconds < MINUTES_FROM_S else f"{seconds / 60:.1f} min"


def _in_training(agents: SwarmClient) -> list[str]:
    """Return the agents that have a training; the only agent, if there is one.

    Raises:
        SwarmError: if none of several has one.
    """
    from hitab_client import SwarmError
    from hitab_core import some

    agents.watch_all()
    there = agents.await_agents()
    found = [name for name in there if agents.statuses[name].examples]
    if found or len(there) == 1:
        return found or there
    if not there:
        raise SwarmError("no agent answers; `hitab status` says why")
    raise SwarmError(
        f"none of {some(there)} is training anything; name the agent and what it has learned, as "
        f"in `hitab report {there[0]} NAME`"
    )
