"""Verbs that drive the world: pause, resume, step, reset, pace, back, place, snapshot, picture."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hitab_cli.verbs.verb_connection import Connection, connection
from hitab_client import SwarmError, console
from hitab_client.terminal.cli_options import SwarmName
from hitab_client.terminal.cli_remedies import with_commands
from hitab_core import Fix, quantity
from hitab_ros.timing import PROMPT_S

if TYPE_CHECKING:
    from hitab_msgs.msg import WorldState

    from hitab_client import WorldClient

app = typer.Typer(help="Drive the world: pause, step, place, snapshot.")


def _control(swarm: str | None, action: str, **fields: object) -> None:
    with connection(swarm) as swarm_up:
        answer = swarm_up.world.control(action, **fields)  # type: ignore[arg-type]
    console.say(answer.message or f"cycle {answer.cycle}")


@app.command()
def pause(swarm: SwarmName = None) -> None:
    """Pause the world after the current cycle."""
    _control(swarm, "pause")


@app.command()
def resume(swarm: SwarmName = None) -> None:
    """Resume the world."""
    _control(swarm, "resume")


@app.command()
def step(cycles: Annotated[int, typer.Argument(min=1)] = 1, swarm: SwarmName = None) -> None:
    """Run some cycles, then pause; ends after the last cycle. Ctrl-C pauses at once.

    Args:
        cycles: Number of cycles.
    """
    with connection(swarm) as swarm_up:
        world = swarm_up.world
        before = world.wait().missed_deadlines
        first = world.state_at(0).episode
        try:
            last = _step(world, cycles).episode
        except KeyboardInterrupt:
            # Otherwise the world would run the remaining cycles.
            stopped = world.control("pause").cycle
            console.note(f"interrupted; the world is paused at cycle {stopped}")
            raise typer.Exit(130) from None
        without = _silent(swarm_up) if world.wait().missed_deadlines > before else []
        ended = _ended(world, range(first, last))
    console.say(f"stepped {quantity(cycles, 'cycle')}")
    if ended:
        console.note(
            f"episode {ended} ended, and episode {last} began: everything has a new place, and "
            "all behaviors are in Start"
        )
    for why in without:
        console.note(with_commands(f"but: {why.problem}", why.remedies))


@app.command()
def picture(path: Path, swarm: SwarmName = None) -> None:
    """Draw the present state of the world.

    Args:
        path: File for the picture, PNG or SVG.

    Example:
      hitab world picture field.png
    """
    from hitab_cli.views.field_picture import draw_field

    with connection(swarm) as swarm_up:
        swarm_up.world.wait()
        state = swarm_up.world.state_at(0)
    draw_field([state], path)
    console.say(f"drawn to {path}")


def _silent(swarm_up: Connection) -> list[SwarmError]:
    """Return why agents do not answer, without which the world has continued."""
    return [
        swarm_up.processes.reason(agent)
        or SwarmError(f"{agent} has not answered in time", Fix.LOGS(node=agent))
        for agent in swarm_up.world.missing
    ]


def _ended(world: WorldClient, episodes: range) -> str:
    """Return the ended episodes with their outcomes, such as ``3 (out)``; empty if none."""

    def outcomes() -> dict[int, str]:
        return {episode.number: f" ({episode.ended})" for episode in world.episodes}

    if episodes:
        world.link.spin_until(lambda: episodes[-1] in outcomes(), PROMPT_S)
    return ", ".join(f"{number}{outcomes().get(number, '')}" for number in episodes)


def _step(world: WorldClient, cycles: int) -> WorldState:
    """Step the world and return its state."""
    with console.progress("stepping", "cycles") as advance:
        return world.step(
            cycles, left=lambda left: advance(cycles - left, cycles, "Ctrl-C pauses")
        )


@app.command()
def reset(swarm: SwarmName = None) -> None:
    """Begin a new episode with all agents in Start; ends when the agents have perceived it."""
    with connection(swarm) as swarm_up:
        answer = swarm_up.world.control("reset")
        swarm_up.world.shown(answer)
    console.say(answer.message or f"cycle {answer.cycle}")


@app.command()
def pace(
    pace: Annotated[str, typer.Argument(show_default=False)] = "",
    factor: Annotated[float | None, typer.Option(min=0.01)] = None,
    teaching: Annotated[float | None, typer.Option(min=0.01, max=1.0)] = None,
    swarm: SwarmName = None,
) -> None:
    """Set how fast the world runs.

    lockstep: the next cycle starts when every agent has answered. realtime: by the clock.

    Args:
        pace: lockstep or realtime. Default: as it is.
        factor: For realtime: multiple of real time, above 0. Default: as it is.
        teaching: For realtime: further factor while an agent is taught; 1 for none. Default: as
            it is.

    Examples:
      hitab world pace lockstep
      hitab world pace realtime --factor 2
      hitab world pace --teaching 0.5
    """
    if not pace and factor is None and teaching is None:
        raise typer.BadParameter("give lockstep or realtime, --factor or --teaching")
    if pace or factor is not None:
        _control(swarm, "pace", pace=pace, factor=factor or 0.0)
    if teaching is not None:
        _control(swarm, "teaching", factor=teaching)


def back(
    seconds: Annotated[float | None, typer.Argument(min=0.0, show_default=False)] = None,
    to: Annotated[int | None, typer.Option("--to", min=1, show_default=False)] = None,
    swarm: SwarmName = None,
) -> None:
    """Put the world back in time, at most a minute and within the episode; it pauses there.

    The agents are in the states of then and keep their examples. A command that you give now is
    recorded there; `hitab world resume` continues.

    Args:
        seconds: Simulated time from now, s.
        to: A cycle instead, such as one that `hitab why` prints.

    Examples:
      hitab back 3
      hitab back --to 424
    """
    if (seconds is None) == (to is None):
        raise typer.BadParameter("give either the seconds to go back or --to a cycle, such as 3")
    with connection(swarm) as swarm_up:
        state = swarm_up.world.go_back(to=to or 0, seconds=seconds or 0.0)
    console.say(f"back at cycle {state.cycle}, paused")


THING_UNITS = {"x": "m", "y": "m", "heading": "degrees", "vx": "m/s", "vy": "m/s"}
"""Settable fields of a thing, with their units in options."""

_PLAIN_NUMBER = re.compile(r"-?(\d+\.?\d*|\.\d+)(e-?\d+)?")


@app.command()
def place(
    things: Annotated[list[str], typer.Argument(metavar="NAME FIELD=VALUE...")],
    new_episode: Annotated[bool, typer.Option("--new-episode")] = False,
    swarm: SwarmName = None,
) -> None:
    """Place things; ends when the agents have perceived the change.

    Other fields are kept, or with --new-episode taken from the new episode.

    Args:
        things: x, y in m, heading in degrees, vx, vy in m/s.
        new_episode: Begin a new episode from these positions; other things get new positions.

    Example:
      hitab world place ball x=3 y=0 keeper_1 x=-5 y=0 heading=90
    """
    placed: dict[str, dict[str, float]] = {}
    name = ""
    for word in things:
        field, is_field, value = word.partition("=")
        if not is_field and not _PLAIN_NUMBER.fullmatch(word):
            name = word
            placed[name] = {}
        elif not name or field not in THING_UNITS or not _PLAIN_NUMBER.fullmatch(value):
            units = ", ".join(f"{known} ({unit})" for known, unit in THING_UNITS.items())
            raise typer.BadParameter(
                f'"{word}": write a name, then its fields, each with a number, such as '
                f"{name or 'ball'} x=1; the fields are {units}"
            )
        else:
            number = float(value)
            placed[name][field] = math.radians(number) if field == "heading" else number
    for name, fields in placed.items():
        if not fields:
            raise typer.BadParameter(f'where to put "{name}"? Write {name} x=1 y=2 heading=90')
    with connection(swarm) as swarm_up:
        answer = swarm_up.world.place(placed, new_episode=new_episode)
        state = swarm_up.world.shown(answer)
    console.say(answer.message or f"placed {', '.join(placed)}")
    if outside := list(_off_the_field(state, placed)):
        console.note(
            f"{', '.join(outside)}: outside of the field, which goes from x={-state.width / 2:g} "
            f"to {state.width / 2:g} m and from y={-state.height / 2:g} to {state.height / 2:g} m"
        )


def _off_the_field(state: WorldState, places: Mapping[str, Mapping[str, float]]) -> Iterator[str]:
    """Yield the names of things that were placed outside of the field."""
    for name, fields in places.items():
        x, y = fields.get("x", 0.0), fields.get("y", 0.0)
        if abs(x) > state.width / 2 or abs(y) > state.height / 2:
            yield name


@app.command()
def snapshot(
    action: str, name: Annotated[str, typer.Argument()] = "", swarm: SwarmName = None
) -> None:
    """Save the world's state under a name, restore it or delete it.

    Args:
        action: save, restore, delete or list.
        name: Name of the snapshot.

    Examples:
      hitab world snapshot save corner
      hitab world snapshot restore corner
    """
    with connection(swarm) as swarm_up:
        answer = swarm_up.world.snapshot(action, name)
    names = f"snapshots: {', '.join(answer.names)}" if answer.names else "no snapshots"
    console.say(f"{answer.message}; {names}" if answer.message else names)
