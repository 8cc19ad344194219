"""A swarm: its agents, their world and their processes.

`swarm_file` reads it from YAML:

    swarm: keepaway
    domain: keepaway
    world: {kind: keepaway, pace: realtime, parameters: {taker_speed: 0.25}}
    start_from: ../libraries/keepaway
    behavior: Keepaway
    agents:
      keeper_1: {}
      keeper_2: {behavior: ""}     # everything above can be set per agent
      keeper_3: {}
      scout: {count: 100, per_process: 50}   # scout_1 ... scout_100 in two processes
    hosts: 4                       # processes for all agents without a process of their own
    kinds:
      Squad: {orders: {Attack: Search, Rest: nothing}, features: {AnyDone: {any: Done}}}
    commanders:
      corporal: {kind: Squad, commands: {scout: 5}}    # corporal_1 ... corporal_20
      captain: {kind: Squad, commands: corporal}       # one over all of them
    namespace: left                # of all nodes, so that two swarms can share a ROS domain
    remap: {/tf: tf}               # here for all nodes; or for the world, an agent, a process
    use_sim_time: true             # the same
    parameters: {max_speed: 0.5}   # of all agents' nodes, links included; or of one agent
    processes:
      relay: {module: my_robot.relay, namespace: keeper_1}

Settings above ``agents`` apply to all agents, so that an agent lists only its differences.
`swarm_lines` has all keys. An agent has no namespace but its name: whoever
works with a swarm finds all its agents in the swarm's namespace.
`hitab_commander.kind_reader` documents kinds of commanders; the default orders of a kind are the
behaviors that all its subordinates share.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from hitab_client import DescriptionError
from hitab_commander import CommanderKind
from hitab_core import VOCABULARY_NAME, VOCABULARY_NAME_RULE

PACES = ("lockstep", "realtime")
AGENT_MARK = "{agent}"
"""Placeholder for the agent's name, in names and texts."""

CLOCK_TOPIC = "/clock"
SIM_TIME = "use_sim_time"


@dataclass(frozen=True)
class WorldDescription:
    """The simulated world of a swarm.

    Attributes:
        kind: of world, such as ``keepaway``.
        module: of its node, run with ``python -m``; see `swarm_file.world_module`.
        pace: ``lockstep`` or ``realtime``, at ``factor`` of real time.
        parameters: of this kind of world, such as ``taker_speed``.
        node_parameters: other parameters of its node, such as ``state_rate``.
        remap: the names that its node uses, each with the one to use instead.
    """

    kind: str
    module: str
    pace: str = "realtime"
    factor: float = 1.0
    seed: int = 1
    paused: bool = False
    parameters: Mapping[str, Any] = field(default_factory=dict)
    node_parameters: Mapping[str, Any] = field(default_factory=dict)
    remap: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class AgentDescription:
    """One agent.

    Attributes:
        library: folder of the library; None for one in the run folder, kept between runs.
        start_from: a library to copy into its own library if that is empty.
        behavior: to start with, such as ``Keepaway``; empty if nothing.
        remap: the names that its node uses, each with the one to use instead.
        parameters: of its node, such as those of its link; a nested one has dots in its name.
        process: name of the process; the agent's own name unless the process is shared.
        library_name: name of its library folder in the run folder; empty for that of the process.
        superior: name of its commander; empty if none.
        role: in its commander's group.
    """

    name: str
    domain: str
    library: Path | None = None
    start_from: Path | None = None
    behavior: str = ""
    seed: int = 1
    process: str = ""
    library_name: str = ""
    superior: str = ""
    role: str = ""
    remap: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class CommanderDescription(AgentDescription):
    """One commander; its domain is its kind.

    Attributes:
        kind: defines its orders and its features.
        subordinates: roles of its subordinates, by name.
        asks_position: whether it needs their positions, for itself or its superiors.
    """

    kind: CommanderKind = field(default_factory=lambda: CommanderKind("", ()))
    subordinates: Mapping[str, str] = field(default_factory=dict)
    asks_position: bool = False


@dataclass(frozen=True)
class Process:
    """One operating-system process of a swarm.

    Attributes:
        name: unique within the swarm; names its log.
        module: run with ``python -m``; empty if the arguments are the command.
        arguments: before those for ROS.
        namespace: of the process's node, or around its several nodes; relative to the swarm's
            namespace in a description, unless it begins with a slash.
        remap, parameters: of its nodes.
        is_node: whether it takes arguments for ROS.
        agents: names of its agents.
    """

    name: str
    module: str
    arguments: tuple[str, ...] = ()
    namespace: str = ""
    remap: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    is_node: bool = True
    agents: tuple[str, ...] = ()

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
    """Write a parameter as JSON, which is YAML, to keep its type."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(_as_yaml, value))}]"
    if isinstance(value, float) and not math.isfinite(value):
        return {math.inf: ".inf", -math.inf: "-.inf"}.get(value, ".nan")
    return json.dumps(value, ensure_ascii=False)


@dataclass(frozen=True)
class SwarmDescription:
    """A whole swarm.

    Attributes:
        namespace: of all its nodes, such as ``/left``; empty if none.
    """

    name: str
    file: Path
    agents: tuple[AgentDescription, ...]
    world: WorldDescription | None = None
    commanders: tuple[CommanderDescription, ...] = ()
    namespace: str = ""
    processes: tuple[Process, ...] = ()

    @property
    def members(self) -> tuple[AgentDescription, ...]:
        """All agents and commanders."""
        return (*self.agents, *self.commanders)

    @property
    def agent_names(self) -> tuple[str, ...]:
        """The names of all agents and commanders."""
        return tuple(member.name for member in self.members)

    @property
    def uses_sim_time(self) -> bool:
        """Whether some nodes of the swarm take their time from the topic ``/clock``."""
        nodes: tuple[AgentDescription | Process, ...] = (*self.members, *self.processes)
        return any(node.parameters.get(SIM_TIME) for node in nodes)

    def full_name(self, name: str) -> str:
        """Return a name in the namespace of the swarm, such as ``/left/robot_1``."""
        return name if name.startswith("/") else f"{self.namespace}/{name}".rstrip("/")

    def remap(self, given: Mapping[str, str]) -> dict[str, str]:
        """Return the remappings of a node: in a namespace, each swarm has its own clock."""
        own = {CLOCK_TOPIC: self.full_name("clock")} if self.namespace else {}
        return {**own, **given}

    def in_namespace(self, namespace: str) -> SwarmDescription:
        """Return the same swarm in another namespace, and named after it too.

        Raises:
            DescriptionError: if that is not a namespace.
        """
        parts = namespace.strip("/").split("/")
        if not all(VOCABULARY_NAME.match(part) for part in parts):
            raise DescriptionError(
                f'"{namespace}" is not a namespace; {VOCABULARY_NAME_RULE}, such as left'
            )
        return replace(self, name="_".join((self.name, *parts)), namespace="/" + "/".join(parts))

    def with_sim_time(self) -> SwarmDescription:
        """Return the same swarm with nodes whose clock is the topic of the world's time."""

        def on(node: Any) -> Any:
            return replace(node, parameters={**node.parameters, SIM_TIME: True})

        return replace(
            self,
            agents=tuple(map(on, self.agents)),
            commanders=tuple(map(on, self.commanders)),
            processes=tuple(on(p) if p.is_node else p for p in self.processes),
        )

    def with_world(self, **changes: Any) -> SwarmDescription:
        """Return the same swarm with changes to its world."""
        if self.world is None:
            raise DescriptionError(f'{self.file}: swarm "{self.name}" has no `world:`')
        return replace(self, world=replace(self.world, **changes))
