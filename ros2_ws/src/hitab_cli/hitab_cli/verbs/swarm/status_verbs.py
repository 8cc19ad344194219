"""Verb that shows the state of a swarm: status."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from hitab_cli.verbs.printing import plain
from hitab_cli.verbs.verb_connection import Connection, connection
from hitab_client import SwarmError, console
from hitab_client.terminal.cli_options import JsonPath, SwarmName
from hitab_client.terminal.cli_remedies import as_command, called
from hitab_core import Fix, each_once, in_groups, natural, quantity, some
from hitab_ros.timing import SETTLE_S

if TYPE_CHECKING:
    from hitab_client.runs.run_processes import Silence
    from hitab_ros import SignsOfLife

AGENT_FIELDS = (
    "domain mode behavior active_path cycle library_digest last_error faults armed stopped "
    "when_out_of_reach note"
)
TRAINING_FIELDS = "examples default_examples questions remarks"
CAUTION_FIELDS = "when_unsure unsure"
WORLD_FIELDS = (
    "world mode pace factor teaching taught held oldest cycle episode missed_deadlines missing "
    "last_error faults"
)
"""Shown fields of statuses."""

WAYS_MAX = 10
"""Maximum number of shown remedies."""

ROWS_MAX = 100
"""Maximum number of agents in the table; JSON has all."""


def status(
    watch: Annotated[bool, typer.Option("--watch", "-w")] = False,
    check: Annotated[bool, typer.Option("--check")] = False,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Show the agents: modes, behaviors and faults.

    Args:
        watch: Keep it up to date.
        check: Exit with 1 if a member does not answer, is stopped or has a fault.

    Examples:
      hitab status
      hitab status --watch
      hitab status --check --json -
    """
    with connection(swarm, reads=True) as swarm_up:
        heard = swarm_up.machines.heard_agents() if swarm_up.machines is not None else ()
        swarm_up.agents.await_agents(heard)
        _await_world(swarm_up)
        reported = (*swarm_up.agents.statuses.values(), swarm_up.world.status)
        swarm_up.note_whose(status.swarm for status in reported if status is not None)
        if watch:
            _watch(swarm_up)
        silent = _silent(swarm_up)
        data = _status_data(swarm_up, silent)
        if swarm_up.record is None and not data["agents"] and data["world"] is None:
            number = swarm_up.link.node.context.get_domain_id()
            raise SwarmError(
                f"no node answers in ROS domain {number}; a swarm that starts or ends needs a "
                "moment: try again",
                Fix.UP(swarm="keepaway"),
            )
        console.show(json, data, *_rendered(data, silent))
        reports = [*data["agents"], *filter(None, [data["world"]])]
        if check and (silent or any(one["faults"] or one.get("missing") for one in reports)):
            raise typer.Exit(1)


def _await_world(swarm_up: Connection) -> None:

    world = swarm_up.world
    if swarm_up.record is None:
        swarm_up.link.spin_until(lambda: world.status is not None, SETTLE_S)
    elif swarm_up.has_world:
        with suppress(SwarmError):  # a missing world is shown with the silent agents
            world.wait()


def _watch(swarm_up: Connection) -> NoReturn:
    signs = swarm_up.agents.signs_of_life(has_world=swarm_up.has_world)
    last: dict[str, Any] = {}

    def shown() -> list[Any]:
        nonlocal last
        swarm_up.agents.discover()
        now = {**swarm_up.agents.statuses, "world": swarm_up.world.status}
        signs.hear_known(name for name, it in now.items() if it is not last.get(name))
        last = now
        silent = _silent(swarm_up, signs)
        return _rendered(_status_data(swarm_up, silent), silent)

    swarm_up.watch(shown)


def _status_data(swarm_up: Connection, silent: Mapping[str, Silence | None]) -> dict[str, Any]:
    """Return the state of a swarm as plain data."""
    from hitab_ros.messages.conversions import remedies_of

    machines = swarm_up.machines
    agents = [
        {
            "agent": name,
            **({"machine": machines.machine_of(name)} if machines is not None else {}),
            "commander": status.order.commander,
            "training": status.training.automaton,
            **plain(status, AGENT_FIELDS),
            **plain(status.training, TRAINING_FIELDS),
            **plain(status.caution, CAUTION_FIELDS),
            "remedies": list(map(as_command, remedies_of(status.remedies))),
        }
        for name, status in sorted(swarm_up.agents.statuses.items())
    ]
    world, record = swarm_up.world.status, swarm_up.record
    return {
        "swarm": record.swarm if record else None,
        "identity": record.identity if record else None,
        "run_folder": str(swarm_up.folder.path) if swarm_up.folder else None,
        "ros_domain": swarm_up.link.node.context.get_domain_id(),
        **({"machines": machines.data()} if machines is not None else {}),
        "agents": agents,
        "missing": [n for n in swarm_up.agents.expected if n not in swarm_up.agents.statuses],
        "silent": {
            name: why.of(name) if why is not None else f"{name} does not answer"
            for name, why in silent.items()
        },
        "world": None if world is None else plain(world, WORLD_FIELDS),
        "remedies": [] if world is None else list(map(as_command, remedies_of(world.remedies))),
    }


def _silent(swarm_up: Connection, signs: SignsOfLife | None = None) -> dict[str, Silence | None]:
    """Return why agents or the world do not answer, by name; None if unknown."""
    from hitab_client.runs.run_processes import Silence

    agents, world, processes = swarm_up.agents, swarm_up.world, swarm_up.processes
    started = (*agents.expected, *(["world"] if swarm_up.has_world else []))
    reasons = {name: processes.why_silent(name) for name in started}
    reported = {*agents.statuses, *(["world"] if world.status is not None else [])}
    # After a report, only an ended or suspended process counts of which no other gives signs.
    lost = agents.lost_of(reported)
    reasons = {n: why for n, why in reasons.items() if n not in reported or n in lost}
    if (machines := swarm_up.machines) is not None:
        silent_machines = {name: machines.why_silent(name) for name in machines.silent()}
        on = {n: it for n in started if (it := machines.machine_of(n)) in silent_machines}
        reasons |= {n: Silence(it, silent_machines[it], lasts=True) for n, it in on.items()}
    for name, seconds in (signs.silent() if signs is not None else {}).items():
        for_now = f"has been silent for {seconds:.0f} s"
        silent = Silence(processes.process_of(name), for_now, lasts=False)
        reasons[name] = reasons.get(name) or processes.why_silent(name) or silent
    return reasons


def _rendered(data: dict[str, Any], silent: Mapping[str, Silence | None]) -> list[Any]:
    from hitab_client.runs.run_processes import sentences

    lines: list[Any] = []
    world = data["world"]
    if world is not None:
        pace = world["pace"]
        if pace == "realtime":
            pace += f" x {world['factor']:g}"
            if world["taught"] and world["teaching"] not in (0.0, 1.0):
                pace += f" x {world['teaching']:g} while an agent is taught"
        lines.append(
            console.line(
                f"world {world['world']}: {world['mode']}, {pace}, cycle {world['cycle']}, "
                f"episode {world['episode']}, {world['missed_deadlines']} missed deadlines"
            )
        )
        if world["held"]:
            resume = as_command(Fix.RESUME_WORLD())
            lines.append(console.line(f"the world is held by {world['held']}; {resume}"))
        if missing := [name for name in world["missing"] if name not in silent]:
            lines.append(console.line(f"the world does not hear {some(missing)}", "red"))
        lines += [console.line(text, "red") for text in _wrong(world)]
    several = data.get("machines", [])
    lines += _machine_lines(several)
    rows = []
    for agent in data["agents"]:
        why = silent.get(agent["agent"])
        examples = f"{agent['examples']} ({agent['default_examples']} default)"
        rows.append(
            (
                agent["agent"],
                why.state if why is not None and why.lasts else agent["mode"],
                agent["behavior"],
                " > ".join(agent["active_path"]),
                examples if agent["examples"] else "",
                agent["library_digest"][:8],
                agent.get("machine", ""),
            )
        )
    for name in data["missing"]:
        if name in silent:
            why = silent[name]
            rows.append((name, "silent" if why is None else why.state, *[""] * 5))
    rows.sort(key=lambda row: natural(row[0]))
    columns = ("agent", "mode", "behavior", "active", "examples", "library", "machine")
    shown = len(columns) if several else -1
    lines.append(console.table(columns[:shown], [row[:shown] for row in rows[:ROWS_MAX]]))
    if len(rows) > ROWS_MAX:
        more = quantity(len(rows) - ROWS_MAX, "more agent")
        lines.append(console.line(f"and {more}; `{called()} status --json -` has all"))
    if not data["agents"]:
        lines.append(console.line("no agent answers"))
    lines += [console.line(why, "red") for why in sentences(silent)]
    wrong = each_once((a["agent"], text) for a in data["agents"] for text in _wrong(a))
    lines += [console.line(text, "red") for text in wrong]
    ways = dict.fromkeys(way for one in [data, *data["agents"]] for way in one["remedies"])
    mute = dict.fromkeys(why.process for why in silent.values() if why is not None)
    mute = {name: None for name in mute if name not in {one["machine"] for one in several}}
    ways |= dict.fromkeys(as_command(Fix.LOGS(node=process)) for process in mute)
    lines += [console.line(way) for way in [*ways][:WAYS_MAX]]
    superiors = {a["agent"]: a["commander"] for a in data["agents"]}
    halt = [a["agent"] for a in data["agents"] if a["when_out_of_reach"] == "halt"]
    listed = some(in_groups(halt, superiors))
    lines += [console.line(f"halt when out of reach: {listed}")] if halt else []
    notes = each_once((a["agent"], a["note"]) for a in data["agents"] if a["note"])
    lines += [console.line(text) for text in notes]
    lines += [console.line(kept) for agent in data["agents"] if (kept := _kept(agent))]
    logs = f"; logs in {data['run_folder']}/logs" if data["run_folder"] else ""
    lines.append(console.line(f"ROS domain {data['ros_domain']}{logs}", "dim"))
    return lines


def _machine_lines(machines: Sequence[Mapping[str, Any]]) -> list[Any]:
    """Return a line per machine, and one per fault that they report of machines that are heard."""
    lines = []
    for machine in machines:
        running = sum(state == "running" for state in machine["processes"].values())
        what = machine["silent"] or f"{quantity(running, 'process', 'processes')} running"
        name = f"{machine['machine']}{' (this one)' if machine['here'] else ''}"
        lines.append(console.line(f"machine {name}: {what}", "red" * bool(machine["silent"])))
    silent = tuple(f"{one['machine']}{end}" for one in machines if one["silent"] for end in ", ")
    faults = dict.fromkeys(fault for machine in machines for fault in machine["faults"])
    # A fault begins with the machine that it is about.
    return lines + [console.line(it, "red") for it in faults if not it.startswith(silent)]


def _kept(agent: Mapping[str, Any]) -> str:
    """Return a text on a suspended training and how to resume it; empty without one."""
    if not agent["training"] or agent["mode"] in ("training", "testing"):
        return ""
    name, examples = agent["agent"], quantity(agent["examples"], "example")
    kept = f'{name}: the training of "{agent["training"]}" ({examples}) is kept'
    return f"{kept}; {as_command(Fix.RESUME(agent=name))}"


def _wrong(status: dict[str, Any]) -> list[str]:
    """Return persistent faults and the last refusal."""
    faults, last = status["faults"], status["last_error"]
    # The last error may be old: present errors are among the faults.
    what = "last refusal" if "agent" in status else "last error"
    problems = [*faults, *([f"{what}: {last}"] if last and last not in faults else [])]
    if status.get("unsure"):
        problems.append(f"unsure: {status['unsure']}")
    if status.get("questions"):
        problems.append(f"asks {quantity(status['questions'], 'question')}")
    if status.get("remarks"):
        see = as_command(Fix.QUESTIONS(agent=status["agent"]))
        problems.append(f"{quantity(status['remarks'], 'sign')} that it does not play; {see}")
    return problems
