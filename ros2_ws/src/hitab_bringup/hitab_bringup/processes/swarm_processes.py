"""Processes of a swarm: its world, agents, hosts, and further programs."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from hitab_bringup.processes.leases import Leases
from hitab_bringup.swarm_files.swarm_description import (
    AgentDescription,
    CommanderDescription,
    Process,
    SwarmDescription,
    WorldDescription,
)
from hitab_core import load_domain
from hitab_ros.names import WORLD

AGENT_MODULE = "hitab_agent.agent_main"
COMMANDER_MODULE = "hitab_commander.commander_main"
HOST_MODULE = "hitab_agent.host_main"
MACHINE_MODULE = "hitab_machines.machine_main"
ALL_ENDPOINTS_MAX = 10
"""Number of agents and commanders up to which hosts open all of their endpoints at once, so that
ROS's tools list them; more would make the start noticeably longer."""

EAGER_PROCESSES_MAX = 25
"""Number of processes above which each creates its services only on request."""

COMPANIONS = "hitab.companions"
"""Entry-point group, by package of a robot's link: a module to run beside each such agent.

It runs in the agent's namespace, with the agent's remappings and parameters.
"""

COMMANDER_NODE = "hitab_commander.commander_node:CommanderNode"


def processes(swarm: SwarmDescription, folder: Path, identity: str = "") -> list[Process]:
    """Return the processes of a swarm that run here, the world first.

    In a swarm on several machines, these are the machine's own, and the machine's node.

    Args:
        swarm: the description.
        folder: the run folder, for libraries and journals.
        identity: identity of the swarm, which its nodes publish in their statuses; empty if none.
    """
    found = all_processes(swarm, folder, identity)
    if not swarm.machine:
        return found
    here = process_names(swarm, found)[swarm.machine]
    space, enclave = swarm.full_name(swarm.machine), swarm.enclave(swarm.machine)
    node = Process(swarm.machine, MACHINE_MODULE, (), space, enclave=enclave)
    return [*(process for process in found if process.name in here), node]


def process_names(swarm: SwarmDescription, found: Sequence[Process]) -> dict[str, tuple[str, ...]]:
    """Return the names of the processes on each machine; companions run beside their agents.

    Args:
        swarm: the description.
        found: all processes of the swarm, see `all_processes`.
    """
    beside = {swarm.full_name(agent.name): agent.process for agent in swarm.agents}
    listed = {name for machine in swarm.machines for name in machine.processes}
    return {
        machine.name: tuple(
            process.name
            for process in found
            if process.name in machine.processes
            or (process.name not in listed and beside.get(process.namespace) in machine.processes)
        )
        for machine in swarm.machines
    }


def all_processes(swarm: SwarmDescription, folder: Path, identity: str = "") -> list[Process]:
    """Return the processes of a swarm, wherever they run, with the settings to run them here.

    See `processes`; the nodes of machines are not among them.
    """
    own = {"swarm": identity} if identity else {}
    found = [] if swarm.world is None else [_world(swarm, swarm.world, folder, own)]
    shared = shared_members(swarm)
    alone = {**own, "services_on_demand": True} if len(shared) > EAGER_PROCESSES_MAX else own
    leases = Leases(folder)
    for name, members in shared.items():
        first = members[0]
        names = tuple(member.name for member in members)
        if not is_host(swarm, members):
            module = COMMANDER_MODULE if isinstance(first, CommanderDescription) else AGENT_MODULE
            space, remap = swarm.full_name(name), swarm.remap(first.remap)
            settings = {**_settings(first, folder), **alone}
            found.append(Process(name, module, (), space, remap, settings, agents=names))
        else:
            settings = {"roster": str(_roster_file(folder, name)), **own}
            chosen, is_small = swarm.all_endpoints, len(swarm.members) <= ALL_ENDPOINTS_MAX
            if chosen or (chosen is None and is_small):
                settings["all_endpoints"] = True
            if swarm.machine:
                settings |= {"machine": swarm.machine, "lease": leases.of(name)}
            found.append(
                Process(name, HOST_MODULE, (), swarm.namespace, {}, settings, agents=names)
            )
    for process in swarm.processes:
        space, remap = swarm.full_name(process.namespace), swarm.remap(process.remap)
        found.append(
            replace(process, namespace=space, remap=remap) if process.is_node else process
        )
    started = {(process.module, process.namespace) for process in found}
    companions = _companions(swarm, folder)
    found += [p for p in companions if (p.module, p.namespace) not in started]
    return [replace(process, enclave=swarm.enclave(process.name)) for process in found]


def is_host(swarm: SwarmDescription, members: Sequence[AgentDescription]) -> bool:
    """Whether a process is a host; on several machines all are, since hosts have leases."""
    return bool(swarm.machines) or [m.name for m in members] != [members[0].process]


def _companions(swarm: SwarmDescription, folder: Path) -> Iterator[Process]:
    """Yield the processes that the links of agents need, such as a relay to the motors."""
    modules = {point.name: point.value for point in entry_points(group=COMPANIONS)}
    packages = {
        domain: load_domain(domain).link.partition(":")[0].partition(".")[0]
        for domain in {agent.domain for agent in swarm.agents if modules}
    }
    for agent in swarm.agents:
        if module := modules.get(packages.get(agent.domain, "")):
            more = {"domain": agent.domain, "state_dir": _state(folder)}
            name, space = f"{agent.name}_{module.rpartition('.')[2]}", swarm.full_name(agent.name)
            remap = swarm.remap(agent.remap)
            yield Process(name, module, (), space, remap, {**agent.parameters, **more})


def shared_members(swarm: SwarmDescription) -> dict[str, list[AgentDescription]]:
    """Return the members of each shared process."""
    shared: dict[str, list[AgentDescription]] = {}
    for member in swarm.members:
        shared.setdefault(member.process, []).append(member)
    return shared


def write_rosters(swarm: SwarmDescription, folder: Path) -> None:
    """Write a file for each host with its members and their settings."""
    for name, members in shared_members(swarm).items():
        roster = [
            {
                "name": member.name,
                **({"node": COMMANDER_NODE} if isinstance(member, CommanderDescription) else {}),
                "parameters": _settings(member, folder),
                "remap": swarm.remap(member.remap),
            }
            for member in members
        ]
        file = _roster_file(folder, name)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(roster, indent=1) + "\n", encoding="utf-8")


def _roster_file(folder: Path, process: str) -> Path:
    return (folder / "rosters" / f"{process}.json").resolve()


def _state(folder: Path) -> str:
    return str((folder / "state").resolve())


def _world(
    swarm: SwarmDescription, world: WorldDescription, folder: Path, own: Mapping[str, Any]
) -> Process:
    parameters = {
        **world.node_parameters,
        "pace": world.pace,
        "factor": world.factor,
        "teaching": world.teaching,
        "seed": world.seed,
        "paused": world.paused,
        "hosts": sum(
            is_host(swarm, members) and any(map(is_in_world, members))
            for members in shared_members(swarm).values()
        ),
        "state_dir": _state(folder),
        **{f"parameters.{name}": value for name, value in world.parameters.items()},
        **own,
    }
    if swarm.machine:
        parameters["machines"] = tuple(machine.name for machine in swarm.machines)
    space, remap = swarm.full_name(WORLD), swarm.remap(world.remap)
    return Process(WORLD, world.module, (), space, remap, parameters)


def is_in_world(member: AgentDescription) -> bool:
    """Whether a member acts in the swarm's world: no commander, and no robot with its own link."""
    return not (isinstance(member, CommanderDescription) or load_domain(member.domain).link)


def library_of(member: AgentDescription, folder: Path) -> Path:
    """Return the library folder of an agent; equal agents in a process share one.

    All commanders of a kind share one.
    """
    name = member.library_name or member.process
    return (member.library or folder / "libraries" / name).resolve()


def kind_file(member: CommanderDescription, folder: Path) -> Path:
    """Return the file that describes the kind of a commander."""
    return (folder / "kinds" / f"{member.kind.name}.yaml").resolve()


def _settings(member: AgentDescription, folder: Path) -> dict[str, Any]:
    """Return the parameters of a node, leaving out defaults."""
    settings: dict[str, Any] = {
        **member.parameters,
        "domain": member.domain,
        "library": str(library_of(member, folder)),
        "state_dir": _state(folder),
        "behavior": member.behavior,
        "seed": member.seed,
    }
    if member.superior:
        settings |= {"commander": member.superior, "role": member.role}
    if isinstance(member, CommanderDescription):
        settings |= {
            "domain": str(kind_file(member, folder)),
            "subordinates": tuple(member.subordinates),
            "roles": tuple(member.subordinates.values()),
            "asks_position": member.asks_position,
        }
    return settings
