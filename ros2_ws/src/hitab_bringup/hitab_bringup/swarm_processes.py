"""The processes of a swarm: command lines of its world, agents and hosts."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from hitab_bringup.swarm_description import (
    AgentDescription,
    CommanderDescription,
    ProcessDescription,
    SwarmDescription,
    WorldDescription,
)
from hitab_core import load_domain
from hitab_ros.names import WORLD

AGENT_MODULE = "hitab_agent.agent_main"
COMMANDER_MODULE = "hitab_commander.commander_main"
HOST_MODULE = "hitab_agent.host_main"
FEW = 25
"""In swarms with more processes, each creates its services only on request."""

COMPANIONS = "hitab.companions"
"""Entry points: a module to run beside each agent whose robot's link is in a package, by package.

It runs in the agent's namespace, with the agent's remappings and parameters.
"""

COMMANDER_NODE = "hitab_commander.commander_node:CommanderNode"


@dataclass(frozen=True)
class Process:
    """One operating-system process of a swarm.

    Attributes:
        name: unique within the swarm; names its log.
        module: Python module to run; empty: the arguments are the command.
        namespace: of its node, or the one around those of its several nodes; empty: none.
        parameters: ROS parameters of its nodes.
        agents: names of its agents.
        remap: names that its nodes use, each with the one to use instead.
        arguments: before those for ROS.
        is_node: whether it takes arguments for ROS.
    """

    name: str
    module: str
    namespace: str
    parameters: Mapping[str, Any]
    agents: tuple[str, ...] = ()
    remap: Mapping[str, str] = field(default_factory=dict)
    arguments: tuple[str, ...] = ()
    is_node: bool = True

    @property
    def program(self) -> list[str]:
        """The command line without the arguments for ROS."""
        return [*([sys.executable, "-m", self.module] if self.module else []), *self.arguments]

    @property
    def command(self) -> list[str]:
        """The command line."""
        line = self.program
        if not self.is_node:
            return line
        line += ["--ros-args", "--disable-external-lib-logs"]
        if self.namespace:
            line += ["-r", f"__ns:={self.namespace}"]
        for name, other in self.remap.items():
            line += ["-r", f"{name}:={other}"]
        for key, value in self.parameters.items():
            line += ["-p", f"{key}:={_as_yaml(value)}"]
        return line


def _as_yaml(value: Any) -> str:
    """Write a parameter so that it keeps its type: JSON is YAML."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(_as_yaml, value))}]"
    if isinstance(value, float) and not math.isfinite(value):
        return {math.inf: ".inf", -math.inf: "-.inf"}.get(value, ".nan")
    return json.dumps(value, ensure_ascii=False)


def processes(swarm: SwarmDescription, folder: Path, identity: str = "") -> list[Process]:
    """Return the processes of a swarm, the world first.

    Args:
        swarm: the description.
        folder: the run folder, for libraries and journals.
        identity: of the swarm, which its nodes publish in their statuses; empty: none.
    """
    found = []
    shared = _shared(swarm)
    if swarm.world is not None:
        found.append(_world(swarm, swarm.world, folder))
    for name, members in shared.items():
        if len(members) == 1 and name == members[0].name:
            alone = _alone(swarm, members[0], folder)
            if len(shared) > FEW:
                alone = replace(alone, parameters={**alone.parameters, "services_on_demand": True})
            found.append(alone)
        else:
            names = tuple(member.name for member in members)
            parameters = {"roster": str(_roster_file(folder, name))}
            found.append(Process(name, HOST_MODULE, swarm.namespace, parameters, names))
    if identity:
        found = [replace(p, parameters={**p.parameters, "swarm": identity}) for p in found]
    found += [_further(swarm, process) for process in swarm.processes]
    there = {(process.module, process.namespace) for process in found}
    return [
        *found,
        *(p for p in _companions(swarm, folder) if (p.module, p.namespace) not in there),
    ]


def _companions(swarm: SwarmDescription, folder: Path) -> Iterator[Process]:
    """Yield what runs beside agents because of their links, such as a relay to the motors."""
    modules = {point.name: point.value for point in entry_points(group=COMPANIONS)}
    packages: dict[str, str] = {}
    for agent in swarm.agents if modules else ():
        if agent.domain not in packages:
            packages[agent.domain] = load_domain(agent.domain).link.partition(":")[0]
        module = modules.get(packages[agent.domain].partition(".")[0])
        if module:
            parameters = {
                **agent.ros.all_parameters,
                "domain": agent.domain,
                "state_dir": str((folder / "state").resolve()),
            }
            yield Process(
                f"{agent.name}_{module.rpartition('.')[2]}",
                module,
                swarm.full_name(agent.name),
                parameters,
                remap=swarm.remap(agent.ros),
            )


def _further(swarm: SwarmDescription, process: ProcessDescription) -> Process:
    return Process(
        process.name,
        process.module,
        swarm.full_name(process.namespace) if process.is_node else "",
        process.ros.all_parameters,
        remap=swarm.remap(process.ros) if process.is_node else {},
        arguments=process.command,
        is_node=process.is_node,
    )


def _shared(swarm: SwarmDescription) -> dict[str, list[AgentDescription]]:
    """Return the members of each shared process."""
    shared: dict[str, list[AgentDescription]] = {}
    for member in swarm.members:
        shared.setdefault(member.process, []).append(member)
    return shared


def write_rosters(swarm: SwarmDescription, folder: Path) -> None:
    """Write a file for each host with its members and their settings."""
    for name, members in _shared(swarm).items():
        roster = [
            {
                "name": member.name,
                **_node_of(member),
                "parameters": _settings(member, folder),
                "remap": swarm.remap(member.ros),
            }
            for member in members
        ]
        file = _roster_file(folder, name)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(roster, indent=1) + "\n", encoding="utf-8")


def _roster_file(folder: Path, process: str) -> Path:
    return (folder / "rosters" / f"{process}.json").resolve()


def _node_of(member: AgentDescription) -> dict[str, str]:
    return {"node": COMMANDER_NODE} if isinstance(member, CommanderDescription) else {}


def _world(swarm: SwarmDescription, world: WorldDescription, folder: Path) -> Process:
    parameters: dict[str, Any] = {
        **world.ros.all_parameters,
        "pace": world.pace,
        "factor": world.factor,
        "seed": world.seed,
        "paused": world.paused,
        "state_dir": str((folder / "state").resolve()),
    }
    parameters |= {f"parameters.{name}": value for name, value in world.parameters.items()}
    remap = swarm.remap(world.ros)
    return Process(WORLD, world.module, swarm.full_name(WORLD), parameters, remap=remap)


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
        **member.ros.all_parameters,
        "domain": member.domain,
        "library": str(library_of(member, folder)),
        "state_dir": str((folder / "state").resolve()),
        "behavior": member.behavior,
        "seed": member.seed,
    }
    if member.without:
        settings["without"] = member.without
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


def _alone(swarm: SwarmDescription, member: AgentDescription, folder: Path) -> Process:
    name = member.name
    module = COMMANDER_MODULE if isinstance(member, CommanderDescription) else AGENT_MODULE
    settings, remap = _settings(member, folder), swarm.remap(member.ros)
    return Process(name, module, swarm.full_name(name), settings, (name,), remap)
