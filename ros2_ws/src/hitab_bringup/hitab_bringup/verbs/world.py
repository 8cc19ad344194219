"""Verbs that drive the world: pause, resume, step, reset, pace, place, snapshot."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hitab_bringup.verbs.connection import connection
from hitab_client import console
from hitab_client.command_options import SwarmName
from hitab_core import quantity

if TYPE_CHECKING:
    from hitab_client import WorldClient

app = typer.Typer(help="Drive the world: pause, step, place, snapshot.", no_args_is_help=True)


def _control(swarm: str | None, action: str, **fields: object) -> None:
    with connection(swarm) as swarm_up:
        answer = swarm_up.world.control(action, **fields)  # type: ignore[arg-type]
    console.say(answer.message or f"cycle {answer.cycle}")


def _seen(world: WorldClient, change: Callable[[], Any]) -> Any:
    """Change the world, wait until the agents have perceived it, and return the answer."""
    answers = []
    world.state_at(0)  # a state from before the change must not pass for one after it
    world.changed(lambda: answers.append(change()))
    return answers[0]


@app.command()
def pause(swarm: SwarmName = None) -> None:
    """Pause the world after the current cycle."""
    _control(swarm, "pause")


@app.command()
def resume(swarm: SwarmName = None) -> None:
    """Resume the world."""
    _control(swarm, "resume")


@app.command()
def step(
    cycles: Annotated[int, typer.Argument(help="Number of cycles.", min=1)] = 1,
    swarm: SwarmName = None,
) -> None:
    """Run some cycles, then pause; ends when they have been run."""
    with connection(swarm) as swarm_up:
        swarm_up.world.step(cycles)
    console.say(f"stepped {quantity(cycles, 'cycle')}")


@app.command()
def reset(swarm: SwarmName = None) -> None:
    """Begin a new episode with all agents in Start; ends when they have perceived it."""
    with connection(swarm) as swarm_up:
        answer = _seen(swarm_up.world, lambda: swarm_up.world.control("reset"))
    console.say(answer.message or f"cycle {answer.cycle}")


@app.command()
def pace(
    pace: Annotated[str, typer.Argument(help="lockstep or realtime.")],
    factor: Annotated[
        float, typer.Option(help="Multiple of real time, for realtime.", min=0.0)
    ] = 0.0,
    swarm: SwarmName = None,
) -> None:
    """Set how fast the world runs.

    lockstep: the next cycle starts when every agent has answered. realtime: by the clock.

    Examples:

      hitab world pace lockstep

      hitab world pace realtime --factor 2
    """
    _control(swarm, "pace", pace=pace, factor=factor)


_FIELD = re.compile(r"(x|y|heading|vx|vy)=(-?[0-9.]+(?:e-?[0-9]+)?)\Z")


@app.command()
def place(
    things: Annotated[
        list[str],
        typer.Argument(
            metavar="NAME FIELD=VALUE...", help="x, y in m, heading in degrees, vx, vy in m/s."
        ),
    ],
    new_episode: Annotated[
        bool, typer.Option("--new-episode", help="Begin a new episode from these positions.")
    ] = False,
    swarm: SwarmName = None,
) -> None:
    """Put things somewhere; ends when the agents have perceived it.

    Fields that are not given are kept.

    Example:

      hitab world place ball x=3 y=0 keeper_1 x=-5 y=0 heading=90
    """
    placed: dict[str, dict[str, float]] = {}
    name = ""
    for word in things:
        match = _FIELD.match(word)
        if match is None and "=" not in word:
            name = word
            placed[name] = {}
        elif match is None or not name:
            raise typer.BadParameter(f'"{word}": write NAME x=1 y=2 heading=90 vx=0 vy=0')
        else:
            value = float(match.group(2))
            field = match.group(1)
            placed[name][field] = math.radians(value) if field == "heading" else value
    with connection(swarm) as swarm_up:
        answer = _seen(
            swarm_up.world, lambda: swarm_up.world.place(placed, new_episode=new_episode)
        )
    console.say(answer.message or f"placed {', '.join(placed)}")


@app.command()
def snapshot(
    action: Annotated[str, typer.Argument(help="save, restore, delete or list.")],
    name: Annotated[str, typer.Argument(help="Name of the snapshot.")] = "",
    swarm: SwarmName = None,
) -> None:
    """Save the world's state under a name, restore it or delete it.

    Examples:

      hitab world snapshot save corner

      hitab world snapshot restore corner
    """
    with connection(swarm) as swarm_up:
        answer = swarm_up.world.snapshot(action, name)
    console.say(f"{answer.message or action}: {', '.join(answer.names) or 'no snapshots'}")
