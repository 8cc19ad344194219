"""The processes of a swarm: command lines of its world, agents and hosts."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from hitab_bringup.swarm_description import (
    AgentDescription,
    CommanderDescription,
    SwarmDescription,
    WorldDescription,
)
from hitab_ros.names import WORLD

AGENT_MODULE = "hitab_agent.agent_main"
COMMANDER_MODULE = "hitab_commander.commander_main"
HOST_MODULE = "hitab_agent.host_main"
FEW = 25
"""In swarms with more processes, each creates its services only on request."""

COMMANDER_NODE = "hitab_commander.commander_node:CommanderNode"


@dataclass(frozen=True)
class Process:
    """One operating-system process of a swarm.

    Attributes:
        name: unique within the swarm; names its log.
        module: Python module to run.
        namespace: of its node; empty if it has several nodes.
        parameters: ROS parameters of its nodes.
        agents: names of its agents.
    """

    name: str
    module: str
    namespace: str
    parameters: Mapping[str, Any]
    agents: tuple[str, ...] = ()

    @property
    def command(self) -> list[str]:
        """The command line."""
        line = [sys.executable, "-m", self.module, "--ros-args", "--disable-external-lib-logs"]
        if self.namespace:
            line += ["-r", f"__ns:={self.namespace}"]
        for key, value in self.parameters.items():
            line += ["-p", f"{key}:={_as_yaml(value)}"]
        return line


def _as_yaml(value: Any) -> str:
    """Write a parameter so that it keeps its type: JSON is YAML."""
    if isinstance(value, tuple):
        value = list(value)
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
        found.append(_world(swarm.world, folder))
    for name, members in shared.items():
        if len(members) == 1 and name == members[0].name:
            alone = _alone(members[0], folder)
            if len(shared) > FEW:
                alone = replace(alone, parameters={**alone.parameters, "services_on_demand": True})
            found.append(alone)
        else:
            names = tuple(member.name for member in members)
            parameters = {"roster": str(_roster_file(folder, name))}
            found.append(Process(name, HOST_MODULE, "", parameters, names))
    if not identity:
        return found
    return [replace(p, parameters={**p.parameters, "swarm": identity}) for p in found]


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
            {"name": member.name, **_node_of(member), "parameters": _settings(member, folder)}
            for member in members
        ]
        file = _roster_file(folder, name)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(roster, indent=1) + "\n", encoding="utf-8")


def _roster_file(folder: Path, process: str) -> Path:
    return (folder / "rosters" / f"{process}.json").resolve()


def _node_of(member: AgentDescription) -> dict[str, str]:
    return {"node": COMMANDER_NODE} if isinstance(member, CommanderDescription) else {}


def _world(world: WorldDescription, folder: Path) -> Process:
    parameters: dict[str, Any] = {
        "pace": world.pace,
        "factor": world.factor,
        "seed": world.seed,
        "paused": world.paused,
        "state_dir": str((folder / "state").resolve()),
    }
    parameters |= {f"parameters.{name}": value for name, value in world.parameters.items()}
    return Process(WORLD, world.module, f"/{WORLD}", parameters)


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


def _alone(member: AgentDescription, folder: Path) -> Process:
    name = member.name
    module = COMMANDER_MODULE if isinstance(member, CommanderDescription) else AGENT_MODULE
    return Process(name, module, f"/{name}", _settings(member, folder), (name,))
