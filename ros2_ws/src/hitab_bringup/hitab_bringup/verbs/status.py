"""The verb that shows what a swarm does: status."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hitab_bringup.kept_trainings import KeptTrainings
from hitab_bringup.verbs.connection import Connection, connection
from hitab_client import console
from hitab_client.command_options import JsonPath, SwarmName
from hitab_client.commands import as_command
from hitab_core import Do, natural, quantity

if TYPE_CHECKING:
    from rich.console import Group

    from hitab_client import SignsOfLife
    from hitab_client.run_processes import Silence

WAYS_MAX = 10
"""Ways out that are shown at most."""

LOOK_SECONDS = 1.0  # for a world that was started by hand


def register(app: typer.Typer) -> None:
    """Add this verb to the command."""
    app.command(rich_help_panel="Swarm")(status)


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
    with connection(swarm, reads=True) as swarm_up:
        swarm_up.agents.await_agents()
        _await_world(swarm_up)
        swarm_up.note_whose(_identities(swarm_up))
        if watch:
            _watch(swarm_up)
            return
        silent = _silent(swarm_up)
        data = _status_data(swarm_up, silent, KeptTrainings(swarm_up.agents))
        if swarm_up.record is None and not data["agents"] and data["world"] is None:
            raise _nobody(swarm_up)
        if json != "-":
            console.out().print(_rendered(data, silent))
        console.write_json(json, data)


def _nobody(swarm_up: Connection) -> Exception:
    """Return an error for when nodes that have been found report nothing."""
    from hitab_client import SwarmError
    from hitab_client.swarm_choice import reported_on
    from hitab_core import some

    topics = some(sorted(reported_on(swarm_up.link)))
    return SwarmError(
        f"nobody answers in ROS domain {swarm_up.link.node.context.get_domain_id()}"
        + (f", although there is somebody on {topics}; " if topics else "; ")
        + "a swarm that starts or ends needs a moment: try again",
        Do.UP(swarm="keepaway"),
    )


def _await_world(swarm_up: Connection) -> None:
    from hitab_client import SwarmError

    world = swarm_up.world
    if swarm_up.record is None:
        swarm_up.link.spin_until(lambda: world.status is not None, LOOK_SECONDS)
    elif swarm_up.has_world:
        with suppress(SwarmError):  # shown with all that does not answer
            world.wait()


def _watch(swarm_up: Connection) -> None:
    from hitab_client import SignsOfLife

    started = (*swarm_up.agents.expected, *(["world"] if swarm_up.has_world else []))
    signs = SignsOfLife(swarm_up.link, started, identity=swarm_up.agents.identity)

    last: dict[str, Any] = {}
    trainings = KeptTrainings(swarm_up.agents)

    def shown() -> Group:
        nonlocal last
        now = {**swarm_up.agents.statuses, "world": swarm_up.world.status}
        signs.take_signs_of(name for name, it in now.items() if it is not last.get(name))
        last = now
        silent = _silent(swarm_up, signs)
        return _rendered(_status_data(swarm_up, silent, trainings), silent)

    with console.live(shown()) as update:
        while True:
            swarm_up.link.spin_until(lambda: False, 0.2)
            swarm_up.agents.discover()
            update(shown())


def _identities(swarm_up: Connection) -> set[str]:
    """Return the swarms of all that have answered."""
    world = swarm_up.world.status
    found = {status.swarm for status in swarm_up.agents.statuses.values()}
    return found | ({world.swarm} if world is not None else set())


def _status_data(
    swarm_up: Connection, silent: Mapping[str, Silence | None], trainings: KeptTrainings
) -> dict[str, Any]:
    """Return all that is known about a swarm, as plain data."""
    from hitab_ros.conversions import remedies_of

    agents = [
        {
            "agent": name,
            "training": trainings.name(s),
            "domain": s.domain,
            "mode": s.mode,
            "behavior": s.behavior,
            "active_path": list(s.active_path),
            "examples": s.examples,
            "default_examples": s.default_examples,
            "cycle": s.cycle,
            "library_digest": s.library_digest,
            "last_error": s.last_error,
            "refused_at": s.refused_at.sec or None,
            "faults": list(s.faults),
            "remedies": list(map(as_command, remedies_of(s.remedies))),
            "note": s.note,
            "unsure": s.unsure,
            "questions": s.questions,
        }
        for name, s in sorted(swarm_up.agents.statuses.items())
    ]
    world = swarm_up.world.status
    return {
        "swarm": swarm_up.record.swarm if swarm_up.record else None,
        "identity": swarm_up.record.identity if swarm_up.record else None,
        "run_folder": str(swarm_up.folder.path) if swarm_up.folder else None,
        "ros_domain": swarm_up.link.node.context.get_domain_id(),
        "agents": agents,
        "missing": [n for n in swarm_up.agents.expected if n not in swarm_up.agents.statuses],
        "silent": {
            name: why.of(name) if why is not None else f"{name} does not answer"
            for name, why in silent.items()
        },
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
            "remedies": list(map(as_command, remedies_of(world.remedies))),
        },
    }


def _silent(swarm_up: Connection, signs: SignsOfLife | None = None) -> dict[str, Silence | None]:
    """Return why agents, or the world, do not answer, by name; None: that is unknown."""
    from hitab_client.run_processes import Silence

    agents, world, processes = swarm_up.agents, swarm_up.world, swarm_up.processes
    started = (*agents.expected, *(["world"] if swarm_up.has_world else []))
    told = {name: processes.why_silent(name) for name in started}
    reported = {*agents.statuses, *(["world"] if world.status is not None else [])}
    # Of one that has reported only a process that has ended or is suspended counts.
    told = {n: why for n, why in told.items() if n not in reported or (why and why.lasts)}
    for name, seconds in (signs.silent() if signs is not None else {}).items():
        for_now = f"has been silent for {seconds:.0f} s"
        silent = Silence(processes.process_of(name), for_now, lasts=False)
        told[name] = processes.why_silent(name) or silent
    return told


def _rendered(data: dict[str, Any], silent: Mapping[str, Silence | None]) -> Group:
    from rich.console import Group

    from hitab_client.run_processes import sentences

    lines: list[Any] = []
    world = data["world"]
    if world is not None:
        pace = world["pace"] + (f" x {world['factor']:g}" if world["pace"] == "realtime" else "")
        lines.append(
            console.line(
                f"world {world['world']}: {world['mode']}, {pace}, cycle {world['cycle']}, "
                f"episode {world['episode']}, {world['missed_deadlines']} missed deadlines"
            )
        )
        for name in world["missing"]:
            lines.append(console.line(f"the world does not hear {name}", "red"))
        lines += [console.line(text, "red") for text in _wrong(world)]
    rows = [
        (
            agent["agent"],
            agent["mode"],
            agent["behavior"],
            " > ".join(agent["active_path"]),
            f"{agent['examples']} ({agent['default_examples']} default)"
            if agent["examples"]
            else "",
            agent["library_digest"][:8],
        )
        for agent in data["agents"]
    ]
    shown = [*_with_states(rows, silent), *_silent_rows(data, silent)]
    shown.sort(key=lambda row: natural(row[0]))
    columns = ("agent", "mode", "behavior", "active", "examples", "library")
    lines.append(console.table(columns, shown))
    if not data["agents"]:
        lines.append(console.line("no agent answers"))
    lines += [console.line(why, "red") for why in sentences(silent)]
    lines += [console.line(text, "red") for text in _wrong_with(data["agents"])]
    of_all = [*data["agents"], *([world] if world is not None else [])]
    ways = list(dict.fromkeys(way for one in of_all for way in one["remedies"]))
    mute = dict.fromkeys(why.process for why in silent.values() if why is not None)
    ways += [as_command(Do.LOGS(node=process)) for process in mute]
    lines += [console.line(way) for way in ways[:WAYS_MAX]]
    notes = [(agent["agent"], agent["note"]) for agent in data["agents"]]
    lines += [console.line(f"{name} {note}") for name, note in notes if note]
    lines += [console.line(_kept(agent)) for agent in data["agents"] if _kept(agent)]
    logs = f"; logs in {data['run_folder']}/logs" if data["run_folder"] else ""
    lines.append(console.line(f"ROS domain {data['ros_domain']}{logs}", "dim"))
    return Group(*lines)


def _kept(agent: Mapping[str, Any]) -> str:
    """Say that a training waits, and how to go on with it; "" if none does."""
    if not agent["training"] or agent["mode"] in ("training", "testing"):
        return ""
    name, examples = agent["agent"], quantity(agent["examples"], "example")
    kept = f'{name}: the training of "{agent["training"]}" ({examples}) is kept'
    return f"{kept}; {as_command(Do.RESUME(agent=name))}"


def _with_states(
    rows: Iterable[tuple[str, ...]], silent: Mapping[str, Silence | None]
) -> Iterator[tuple[str, ...]]:
    """Yield the rows of agents; for a mode, why the process of one does not run."""
    for name, mode, *rest in rows:
        why = silent.get(name)
        yield (name, why.state if why is not None and why.lasts else mode, *rest)


def _silent_rows(
    data: dict[str, Any], silent: Mapping[str, Silence | None]
) -> Iterator[tuple[str, ...]]:
    """Yield a row for each agent of which it is only known that it does not answer."""
    known = {agent["agent"] for agent in data["agents"]}
    for name, why in silent.items():
        if name not in known and name in data["missing"]:
            yield (name, "silent" if why is None else why.state, "", "", "", "")


def _wrong_with(agents: list[dict[str, Any]]) -> list[str]:
    """Return what is wrong with agents, each text once with the names of those concerned."""
    from hitab_core import each_once

    return each_once((agent["agent"], text) for agent in agents for text in _wrong(agent))


def _wrong(status: dict[str, Any]) -> list[str]:
    """Return persistent faults and the last refusal."""
    faults, last = status["faults"], status["last_error"]
    # It may have been long ago: what is still so is among the faults.
    what = f"last refusal{_at(status)}" if "agent" in status else "last error"
    told = [*faults, *([f"{what}: {last}"] if last and last not in faults else [])]
    if status.get("unsure"):
        told.append(f"unsure: {status['unsure']}")
    if status.get("questions"):
        told.append(f"asks {quantity(status['questions'], 'question')}")
    return told


def _at(status: dict[str, Any]) -> str:
    """Return when an agent refused, in local time."""
    refused = status["refused_at"]
    return "" if refused is None else time.strftime(" at %H:%M:%S", time.localtime(refused))
