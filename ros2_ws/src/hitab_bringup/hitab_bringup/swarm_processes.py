"""The processes of a swarm: the command lines of its world, agents and hosts of many agents."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hitab_bringup.errors import DescriptionError
from hitab_bringup.names import WORLD
from hitab_bringup.swarm_description import AgentDescription, SwarmDescription, WorldDescription

AGENT_MODULE = "hitab_agent.agent_main"
HOST_MODULE = "hitab_agent.host_main"


@dataclass(frozen=True)
class Process:
    """One operating-system process of a swarm.

    Attributes:
        name: unique within the swarm; names its log.
        module: Python module that is run.
        namespace: of its node; empty where the process has several.
        parameters: ROS parameters of its nodes.
        agents: names of the agents that run in it.
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
    """Write a parameter so that it is read back with the same type: JSON is YAML."""
    if isinstance(value, tuple):
        value = list(value)
    return json.dumps(value, ensure_ascii=False)


def processes(swarm: SwarmDescription, folder: Path) -> list[Process]:
    """Return the processes of a swarm, the world first.

    Args:
        swarm: the description.
        folder: the run folder, for libraries and journals.

    Raises:
        DescriptionError: if agents that are to share a process differ.
    """
    found = []
    if swarm.world is not None:
        found.append(_world(swarm.world))
    shared: dict[str, list[AgentDescription]] = {}
    for agent in swarm.agents:
        shared.setdefault(agent.process, []).append(agent)
    for name, agents in shared.items():
        if len(agents) == 1 and name == agents[0].name:
            found.append(_agent(agents[0], folder))
        else:
            found.append(_host(swarm, name, agents, folder))
    return found


def _world(world: WorldDescription) -> Process:
    parameters: dict[str, Any] = {
        "pace": world.pace,
        "factor": world.factor,
        "seed": world.seed,
        "paused": world.paused,
    }
    parameters |= {f"parameters.{name}": value for name, value in world.parameters.items()}
    return Process(WORLD, world.module, f"/{WORLD}", parameters)


def library_of(agent: AgentDescription, folder: Path) -> Path:
    """Return the library folder of an agent; those that share a process share it."""
    return (agent.library or folder / "libraries" / agent.process).resolve()


def _settings(agent: AgentDescription, folder: Path) -> dict[str, Any]:
    """Return the parameters of an agent's node."""
    return {
        "domain": agent.domain,
        "library": str(library_of(agent, folder)),
        "state_dir": str((folder / "state").resolve()),
        "behavior": agent.behavior,
        "seed": agent.seed,
    }


def _agent(agent: AgentDescription, folder: Path) -> Process:
    name = agent.name
    return Process(name, AGENT_MODULE, f"/{name}", _settings(agent, folder), (name,))


def _host(
    swarm: SwarmDescription, name: str, agents: list[AgentDescription], folder: Path
) -> Process:
    first, *others = agents
    for agent in others:
        for what in ("domain", "behavior", "seed", "library", "start_from"):
            if getattr(agent, what) != getattr(first, what):
                raise DescriptionError(
                    f'{swarm.file}: agents "{first.name}" and "{agent.name}" share the process '
                    f'"{name}" but differ in `{what}`; put them into different processes'
                )
    names = tuple(agent.name for agent in agents)
    return Process(name, HOST_MODULE, "", {"agents": names, **_settings(first, folder)}, names)
