"""Verbs for whole swarms: up, down, status."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hitab_bringup.verbs.connection import Connection, connection
from hitab_client import console
from hitab_client.command_options import JsonPath, SwarmName
from hitab_core import quantity

if TYPE_CHECKING:
    from rich.console import Group

PANEL = "Swarm"
RunDir = Annotated[
    Path | None,
    typer.Option("--run-dir", help="Folder for its files, instead of the default one."),
]


def register(app: typer.Typer) -> None:
    """Add these verbs to the command."""
    app.command(rich_help_panel=PANEL)(up)
    app.command(rich_help_panel=PANEL)(down)
    app.command(rich_help_panel=PANEL)(status)


def up(
    swarm: Annotated[
        str, typer.Argument(help="A swarm description, or the name of a shipped one.")
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
    from hitab_client.shipped import find_file
    from hitab_bringup.swarm_description import PACES
    from hitab_bringup.swarm_file import read_swarm
    from hitab_client import RunFolder

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
    with console.progress(f"starting {description.name}") as advance:
        record = bring_up(description, folder, advance)
    console.say(
        f"{record.swarm} is up: {quantity(len(record.agents), 'agent')}"
        f"{' and a world' if record.world else ''} in ROS domain {record.domain_id} "
        f"({time.monotonic() - began:.1f} s)"
    )
    console.say(f"files in {folder.path}; look with `hitab status`, stop with `hitab down`")


def down(
    name: Annotated[
        str | None, typer.Argument(metavar="[SWARM]", help="The swarm, if several are up.")
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


def status(
    watch: Annotated[bool, typer.Option("--watch", "-w", help="Keep it up to date.")] = False,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Show the agents: their modes, what they perform and what went wrong.

    Examples:

      hitab status

      hitab status --watch
    """
    with connection(swarm) as swarm_up:
        swarm_up.agents.await_agents()
        if swarm_up.record is None or swarm_up.record.world:
            swarm_up.link.spin_until(lambda: swarm_up.world.status is not None, 4.0)
        if watch:
            _watch(swarm_up)
            return
        data = _status_data(swarm_up)
        if json != "-":
            console.out().print(_rendered(data))
        console.write_json(json, data)


def _watch(swarm_up: Connection) -> None:
    from rich.live import Live

    with Live(_rendered(_status_data(swarm_up)), console=console.out(), screen=False) as live:
        while True:
            swarm_up.link.spin_until(lambda: False, 0.2)
            swarm_up.agents.discover()
            live.update(_rendered(_status_data(swarm_up)))


def _status_data(swarm_up: Connection) -> dict[str, Any]:
    """Return all that is known about a swarm, as plain data."""
    agents = [
        {
            "agent": name,
            "domain": s.domain,
            "mode": s.mode,
            "behavior": s.behavior,
            "active_path": list(s.active_path),
            "examples": s.examples,
            "default_examples": s.default_examples,
            "cycle": s.cycle,
            "library_digest": s.library_digest,
            "last_error": s.last_error,
            "faults": list(s.faults),
        }
        for name, s in sorted(swarm_up.agents.statuses.items())
    ]
    world = swarm_up.world.status
    missing = [n for n in swarm_up.agents.expected if n not in swarm_up.agents.statuses]
    return {
        "swarm": swarm_up.record.swarm if swarm_up.record else None,
        "identity": swarm_up.record.identity if swarm_up.record else None,
        "run_folder": str(swarm_up.folder.path) if swarm_up.folder else None,
        "agents": agents,
        "missing": missing,
        "world": None
        if world is None
        else {
            "world": world.world,
            "mode": world.mode,
            "pace": world.pace,
            "factor": world.factor,
            "cycle": world.cycle,
            "episode": world.episode,
            "missed_deadlines": world.missed_deadlines,
            "missing": list(world.missing),
            "last_error": world.last_error,
            "faults": list(world.faults),
        },
    }


def _rendered(data: dict[str, Any]) -> Group:
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    lines: list[Any] = []
    world = data["world"]
    if world is not None:
        pace = world["pace"] + (f" x {world['factor']:g}" if world["pace"] == "realtime" else "")
        lines.append(
            Text(
                f"world {world['world']}: {world['mode']}, {pace}, cycle {world['cycle']}, "
                f"episode {world['episode']}, {world['missed_deadlines']} missed deadlines"
            )
        )
        for name in world["missing"]:
            lines.append(Text(f"the world does not hear {name}", style="red"))
        lines += [Text(text, style="red") for text in _wrong(world)]
    table = Table(box=None, pad_edge=False)
    for column in ("agent", "mode", "behavior", "active", "examples", "library"):
        table.add_column(column)
    for agent in data["agents"]:
        examples = f"{agent['examples']} ({agent['default_examples']} default)"
        table.add_row(
            agent["agent"],
            agent["mode"],
            agent["behavior"],
            " > ".join(agent["active_path"]),
            examples if agent["examples"] else "",
            agent["library_digest"][:8],
        )
    lines.append(table)
    if not data["agents"]:
        lines.append(Text("no agent answers; start a swarm with `hitab up`"))
    for name in data["missing"]:
        lines.append(Text(f"{name} does not answer", style="red"))
    for agent in data["agents"]:
        lines += [Text(f"{agent['agent']}: {text}", style="red") for text in _wrong(agent)]
    if data["run_folder"]:
        lines.append(Text(f"logs in {data['run_folder']}/logs", style="dim"))
    return Group(*lines)


def _wrong(status: dict[str, Any]) -> list[str]:
    """Return persistent faults and the last refusal."""
    faults, last = status["faults"], status["last_error"]
    return [*faults, *([last] if last and last not in faults else [])]
