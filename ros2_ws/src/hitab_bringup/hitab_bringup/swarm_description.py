"""A swarm: which agents, in which world, in which processes.

`hitab_bringup.swarm_file` reads it from YAML:

    swarm: keepaway
    domain: keepaway
    world: {kind: keepaway, pace: realtime, parameters: {taker_speed: 0.25}}
    start_from: ../libraries/keepaway
    behavior: Keepaway
    agents:
      keeper_1: {}
      keeper_2: {behavior: ""}     # anything above may be set for one agent alone
      scout: {count: 100, per_process: 50}   # scout_1 ... scout_100 in two processes

What stands above ``agents`` holds for all of them, so that a team of likes is short to write and
an unlike one just says where it differs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from hitab_bringup.errors import DescriptionError

PACES = ("lockstep", "realtime")


@dataclass(frozen=True)
class WorldDescription:
    """The world in which a swarm lives, if it is a simulated one.

    Attributes:
        kind: of world, such as ``keepaway``.
        module: of its node, run by ``python -m``; see `hitab_bringup.swarm_file.world_module`.
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
        library: its library folder; None: in the run folder, kept from run to run.
        start_from: a library that is copied into its own when that is empty.
        behavior: what it performs at first, such as ``Keepaway``; empty: nothing.
        process: name of the process in which it runs; its own name unless it shares one.
    """

    name: str
    domain: str
    library: Path | None = None
    start_from: Path | None = None
    behavior: str = ""
    seed: int = 1
    process: str = ""


@dataclass(frozen=True)
class SwarmDescription:
    """A whole swarm."""

    name: str
    file: Path
    agents: tuple[AgentDescription, ...]
    world: WorldDescription | None = None

    @property
    def agent_names(self) -> tuple[str, ...]:
        """The names of all agents."""
        return tuple(agent.name for agent in self.agents)

    def with_world(self, **changes: Any) -> SwarmDescription:
        """Return the same swarm in a world that differs."""
        if self.world is None:
            raise DescriptionError(f'{self.file}: swarm "{self.name}" has no `world:`')
        return replace(self, world=replace(self.world, **changes))

    def with_agents(self, **changes: Any) -> SwarmDescription:
        """Return the same swarm with something changed in all agents."""
        return replace(self, agents=tuple(replace(a, **changes) for a in self.agents))
