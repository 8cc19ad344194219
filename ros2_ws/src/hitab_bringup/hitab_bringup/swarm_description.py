"""A swarm: its agents, their world and their processes.

`hitab_bringup.swarm_file` reads it from YAML:

    swarm: keepaway
    domain: keepaway
    world: {kind: keepaway, pace: realtime, parameters: {taker_speed: 0.25}}
    start_from: ../libraries/keepaway
    behavior: Keepaway
    agents:
      keeper_1: {}
      keeper_2: {behavior: ""}     # everything above can be set per agent
      keeper_3: {without: [ServoBall]}   # a hand-written automaton taken out of the domain
      scout: {count: 100, per_process: 50}   # scout_1 ... scout_100 in two processes
    hosts: 4                       # processes for all agents without a process of their own
    kinds:
      Squad: {orders: {Attack: Search, Rest: nothing}, features: {AnyDone: {any: Done}}}
    commanders:
      corporal: {kind: Squad, commands: {scout: 5}}    # corporal_1 ... corporal_20
      captain: {kind: Squad, commands: corporal}       # one over all of them

Settings above ``agents`` apply to all agents, so that an agent lists only its differences.
`hitab_commander.kind_reader` documents kinds of commanders; the default orders of a kind are the
behaviors that all its subordinates share.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from hitab_client import DescriptionError
from hitab_commander import CommanderKind

PACES = ("lockstep", "realtime")


@dataclass(frozen=True)
class WorldDescription:
    """The simulated world of a swarm.

    Attributes:
        kind: of world, such as ``keepaway``.
        module: of its node, run with ``python -m``; see `hitab_bringup.swarm_file.world_module`.
        pace: ``lockstep`` or ``realtime``, at ``factor`` of real time.
        parameters: of this kind of world, such as ``taker_speed``.
    """

    kind: str
    module: str
    pace: str = "realtime"
    factor: float = 1.0
    seed: int = 1
    paused: bool = False
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class AgentDescription:
    """One agent.

    Attributes:
        library: its library folder; None: a folder in the run folder, kept between runs.
        start_from: a library to copy into its own library if that is empty.
        behavior: to start with, such as ``Keepaway``; empty: nothing.
        without: hand-written automata of its domain that are taken out.
        process: that it runs in; its own name unless it shares one.
        library_name: name of its library folder in the run folder; empty: that of the process.
        superior: name of its commander; empty: none.
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
    without: tuple[str, ...] = ()


@dataclass(frozen=True)
class CommanderDescription(AgentDescription):
    """One commander; its domain is its kind.

    Attributes:
        kind: defines what it can order and perceive.
        subordinates: roles of its subordinates, by name.
        asks_position: whether it needs their positions, for itself or its superiors.
    """

    kind: CommanderKind = field(default_factory=lambda: CommanderKind("", ()))
    subordinates: Mapping[str, str] = field(default_factory=dict)
    asks_position: bool = False


@dataclass(frozen=True)
class SwarmDescription:
    """A whole swarm."""

    name: str
    file: Path
    agents: tuple[AgentDescription, ...]
    world: WorldDescription | None = None
    commanders: tuple[CommanderDescription, ...] = ()

    @property
    def members(self) -> tuple[AgentDescription, ...]:
        """All agents and commanders."""
        return (*self.agents, *self.commanders)

    @property
    def agent_names(self) -> tuple[str, ...]:
        """The names of all agents and commanders."""
        return tuple(member.name for member in self.members)

    def with_world(self, **changes: Any) -> SwarmDescription:
        """Return the same swarm with changes to its world."""
        if self.world is None:
            raise DescriptionError(f'{self.file}: swarm "{self.name}" has no `world:`')
        return replace(self, world=replace(self.world, **changes))

    def with_agents(self, **changes: Any) -> SwarmDescription:
        """Return the same swarm with changes to all agents."""
        return replace(self, agents=tuple(replace(a, **changes) for a in self.agents))
