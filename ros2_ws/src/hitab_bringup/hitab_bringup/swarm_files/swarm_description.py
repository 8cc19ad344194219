"""Description of a swarm: its agents, their world and their processes.

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
`swarm_lines` has all keys. The namespace of an agent is its name within the swarm's namespace, in
which programs find all agents of the swarm.
`hitab_commander.kinds.kind_reader` documents kinds of commanders; the default orders of a kind are
the behaviors that all its subordinates share.
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
from hitab_client.connecting.identity import new_identity, shared_identity
from hitab_commander import CommanderKind
from hitab_core import VOCABULARY_NAME, VOCABULARY_NAME_RULE, has

PACES = ("lockstep", "realtime")
AGENT_MARK = "{agent}"
"""Placeholder for the agent's name, in names and texts."""

CLOCK_TOPIC = "/clock"
SIM_TIME = "use_sim_time"


@dataclass(frozen=True)
class WorldDescription:
    """The simulated world of a swarm.

    Attributes:
        kind: kind of world, such as ``keepaway``.
        module: module of the world's node, run with ``python -m``; see
            `swarm_file.world_module`.
        pace: ``lockstep`` or ``realtime``, at ``factor`` of real time.
        teaching: further factor while an agent is taught; 1 for none.
        parameters: parameters of this kind of world, such as ``taker_speed``.
        node_parameters: other parameters of the world's node, such as ``state_rate``.
        remap: remappings of the node: new names, by original name.
    """

    kind: str
    module: str
    pace: str = "realtime"
    factor: float = 1.0
    teaching: float = 0.5
    seed: int = 1
    paused: bool = False
    parameters: Mapping[str, Any] = field(default_factory=dict)
    node_parameters: Mapping[str, Any] = field(default_factory=dict)
    remap: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class AgentDescription:
    """One agent.

    Attributes:
        library: library folder; None for a folder in the run folder, kept between runs.
        start_from: library that is copied into the agent's own library if that is empty.
        behavior: initial behavior, such as ``Keepaway``; empty for none.
        remap: remappings of the node: new names, by original name.
        parameters: parameters of the node and its link; nested names have dots.
        process: name of the process; the agent's own name unless the process is shared.
        library_name: name of the library folder in the run folder; empty for the process's name.
        superior: name of the agent's commander; empty if none.
        role: role in the commander's group.
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
    """One commander, whose domain is its kind.

    Attributes:
        kind: kind, which defines the orders and features.
        subordinates: roles of the subordinates, by name.
        asks_position: whether the commander or its superiors need the subordinates' positions.
    """

    kind: CommanderKind = field(default_factory=lambda: CommanderKind("", ()))
    subordinates: Mapping[str, str] = field(default_factory=dict)
    asks_position: bool = False


@dataclass(frozen=True)
class Process:
    """One operating-system process of a swarm.

    Attributes:
        name: name, unique within the swarm; also of the log.
        module: module, run with ``python -m``; empty if the arguments are the command.
        arguments: arguments before those for ROS.
        namespace: namespace of the process's node, or around its several nodes; relative to the
            swarm's namespace in a description, unless it begins with a slash.
        remap, parameters: remappings and parameters of the nodes.
        is_node: whether the process takes arguments for ROS.
        agents: names of the agents in the process.
        enclave: path of the keys and rights of the process, if ROS's security is on.
    """

    name: str
    module: str
    arguments: tuple[str, ...] = ()
    namespace: str = ""
    remap: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    is_node: bool = True
    agents: tuple[str, ...] = ()
    enclave: str = "/"

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
        line += ["--ros-args", "--disable-external-lib-logs", "--enclave", self.enclave]
        if self.namespace:
            line += ["-r", f"__ns:={self.namespace}"]
        for name, other in self.remap.items():
            line += ["-r", f"{name}:={other}"]
        for key, value in self.parameters.items():
            line += ["-p", f"{key}:={_as_yaml(value)}"]
        return line


def _as_yaml(value: Any) -> str:
    """Return a parameter as JSON, which is valid YAML and keeps the type."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(_as_yaml, value))}]"
    if isinstance(value, float) and not math.isfinite(value):
        return {math.inf: ".inf", -math.inf: "-.inf"}.get(value, ".nan")
    return json.dumps(value, ensure_ascii=False)


@dataclass(frozen=True)
class MachineDescription:
    """One machine: a computer that runs part of a swarm.

    Attributes:
        processes: names of the processes that it runs, without companions of robots, which run
            beside their agents.
        ssh: destination for the system's ``ssh``; empty if none.
        hitab: the command ``hitab`` there.
        takes_over: names of the machines whose processes it takes over when they are silent.
    """

    name: str
    processes: tuple[str, ...]
    ssh: str = ""
    hitab: str = "hitab"
    takes_over: tuple[str, ...] = ()


@dataclass(frozen=True)
class SwarmDescription:
    """A complete swarm.

    Attributes:
        namespace: namespace of all nodes, such as ``/left``; empty if none.
        all_endpoints: whether hosts open all topics and services of their agents at once, instead
            of those that somebody asks for; None if the number of agents decides.
        machines: the machines that run its parts; empty if it runs on one, unnamed.
        machine: the machine whose part is started here; empty for the whole swarm.
    """

    name: str
    file: Path
    agents: tuple[AgentDescription, ...]
    world: WorldDescription | None = None
    commanders: tuple[CommanderDescription, ...] = ()
    namespace: str = ""
    processes: tuple[Process, ...] = ()
    all_endpoints: bool | None = None
    machines: tuple[MachineDescription, ...] = ()
    machine: str = ""

    @property
    def members(self) -> tuple[AgentDescription, ...]:
        """All agents and commanders."""
        return (*self.agents, *self.commanders)

    @property
    def agent_names(self) -> tuple[str, ...]:
        """The names of all agents and commanders."""
        return tuple(member.name for member in self.members)

    @property
    def members_here(self) -> tuple[AgentDescription, ...]:
        """The agents and commanders that run on the chosen machine."""
        return tuple(member for member in self.members if self.runs(member.process))

    def runs(self, process: str) -> bool:
        """Whether a process of a member, a further process or the world runs here."""
        here = {name for m in self.machines if m.name == self.machine for name in m.processes}
        return not self.machine or process in here

    @property
    def uses_sim_time(self) -> bool:
        """Whether some nodes of the swarm take their time from the topic ``/clock``."""
        nodes: tuple[AgentDescription | Process, ...] = (*self.members, *self.processes)
        return any(node.parameters.get(SIM_TIME) for node in nodes)

    def identity(self, *, launched: bool = False) -> str:
        """Return an identity: that of the swarm on all its machines, or else a new one.

        Args:
            launched: whether the swarm is started without `hitab up`.
        """
        if self.machine:
            machines = (machine.name for machine in self.machines)
            return shared_identity(self.name, self.namespace, machines)
        return new_identity(self.name, launched=launched)

    def full_name(self, name: str) -> str:
        """Return a name in the namespace of the swarm, such as ``/left/robot_1``."""
        return name if name.startswith("/") else f"{self.namespace}/{name}".rstrip("/")

    def enclave(self, process: str) -> str:
        """Return the enclave of a process, such as ``/keepaway/keeper_1``."""
        return f"/{self.name}/{process}"

    def remap(self, given: Mapping[str, str]) -> dict[str, str]:
        """Return a node's remappings, with the swarm's own clock if it has a namespace."""
        own = {CLOCK_TOPIC: self.full_name("clock")} if self.namespace else {}
        return {**own, **given}

    def in_namespace(self, namespace: str) -> SwarmDescription:
        """Return the swarm in another namespace, which also becomes part of its name.

        Raises:
            DescriptionError: if the text is not a namespace.
        """
        parts = namespace.strip("/").split("/")
        if not all(VOCABULARY_NAME.match(part) for part in parts):
            raise DescriptionError(
                f'"{namespace}" is not a namespace; {VOCABULARY_NAME_RULE}, such as left'
            )
        return replace(self, name="_".join((self.name, *parts)), namespace="/" + "/".join(parts))

    def on_machine(self, name: str) -> SwarmDescription:
        """Return the swarm with the machine whose part is to be started.

        Raises:
            DescriptionError: if the swarm has no such machine, or several and none is named.
        """
        names = [machine.name for machine in self.machines]
        if name and not names:
            raise DescriptionError(
                f'{self.file}: swarm "{self.name}" has no `machines:`; leave out the machine'
            )
        if names and not name:
            raise DescriptionError(
                f'{self.file}: swarm "{self.name}" runs on {", ".join(names)}; say which of these '
                f"this is, as in --machine {names[0]}, or start all with --all"
            )
        if name not in {*names, ""}:
            raise DescriptionError(f'{self.file}: no machine "{name}" {has(names, name)}')
        return replace(self, machine=name)

    def with_sim_time(self) -> SwarmDescription:
        """Return the swarm with nodes whose clock is the topic of the world's time."""

        def on(node: Any) -> Any:
            return replace(node, parameters={**node.parameters, SIM_TIME: True})

        return replace(
            self,
            agents=tuple(map(on, self.agents)),
            commanders=tuple(map(on, self.commanders)),
            processes=tuple(on(p) if p.is_node else p for p in self.processes),
        )

    def with_world(self, **changes: Any) -> SwarmDescription:
        """Return the swarm with changes to its world."""
        if self.world is None:
            raise DescriptionError(f'{self.file}: swarm "{self.name}" has no `world:`')
        return replace(self, world=replace(self.world, **changes))
