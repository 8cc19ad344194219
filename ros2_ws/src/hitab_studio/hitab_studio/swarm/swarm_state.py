"""The known state of the swarm: immutable and replaced as a whole, so that pages see changes."""

from __future__ import annotations

import math
import time
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

from hitab_client.attention import Item
from hitab_client.runs.run_processes import Silence
from hitab_core import natural
from hitab_ros import KnownStops, names
from hitab_ros.timing import ANSWER_S
from hitab_studio.field.remembered_scenes import Key
from hitab_studio.field.scene import SILENT_MODE, Scene, state_shown
from hitab_studio.kept import while_same
from hitab_studio.robots.watch import Robots
from hitab_studio.swarm.agent_watch import AgentState
from hitab_studio.swarm.received_vocabulary import NO_ITEMS
from hitab_studio.swarm.swarm_finder import SwarmTarget


@dataclass(frozen=True)
class SwarmState:
    """The known state of a swarm at one moment.

    Attributes:
        target: the swarm to connect to; None before the first search.
        revision: raised with each change that pages show.
        world: the last `WorldStatus`; None before the first.
        scene: the last scene of the world; None before the first.
        statuses: the last `AgentStatus` of each agent, by name.
        joined: time at which the last new agent was heard, or else of the connection, on the
            monotonic clock, s.
        silent: agents, or `names.WORLD`, that give no signs of life or have left the graph, with
            the time of the last sign on the monotonic clock, s.
        why: reasons for the silence of processes, if the swarm's supervisor knows them.
        groups: the last `CommanderStatus` of each commander, by name.
        watched: states of the viewed agents, by name.
        moments: scenes of the recorded examples.
        elsewhere: identities of swarms that were started elsewhere, if none was started here.
        attention: what deserves a look, the most important first.
        machines: the machines of the swarm that were heard, by name, each with the time of its
            last sign on the monotonic clock, s, if it is silent; None otherwise.
        machine_of: machine of each agent in a swarm with machines, by the agent's name.
        emergency: the known emergency stops.
        stopped_at: time at which the first of these was heard, on the wall clock, s.
        recording: the file of the run being recorded; "" if none.
        recorded: number of recorded messages.
        robots: state of real robots; None with a simulated world, or before an agent is heard.
    """

    target: SwarmTarget | None = None
    revision: int = 0
    world: Any = None
    scene: Scene | None = None
    statuses: Mapping[str, Any] = field(default_factory=lambda: NO_ITEMS)
    joined: float = -math.inf
    silent: Mapping[str, float] = field(default_factory=lambda: NO_ITEMS)
    why: Mapping[str, Silence] = field(default_factory=lambda: NO_ITEMS)
    groups: Mapping[str, Any] = field(default_factory=lambda: NO_ITEMS)
    watched: Mapping[str, AgentState] = field(default_factory=lambda: NO_ITEMS)
    moments: Mapping[Key, Scene] = field(default_factory=lambda: NO_ITEMS)
    elsewhere: tuple[str, ...] = ()
    attention: tuple[Item, ...] = ()
    machines: Mapping[str, float | None] = field(default_factory=lambda: NO_ITEMS)
    machine_of: Mapping[str, str] = field(default_factory=lambda: NO_ITEMS)
    emergency: KnownStops = field(default_factory=KnownStops)
    stopped_at: float = 0.0
    recording: str = ""
    recorded: int = 0
    robots: Robots | None = None

    @cached_property
    def members(self) -> frozenset[str]:
        """Names of the present and of the expected agents."""
        expected = self.target.agents if self.target is not None else ()
        return frozenset(self.statuses).union(expected)

    @property
    def agents(self) -> tuple[str, ...]:
        """Names of the present and of the expected agents, in order."""
        return _in_order(self.members)

    @cached_property
    def unheard(self) -> tuple[str, ...]:
        """Names of the expected agents that were never heard."""
        return _in_order(self.members.difference(self.statuses))

    @property
    def is_waiting(self) -> bool:
        """Whether agents that were never heard may still appear."""
        return bool(self.unheard) and time.monotonic() < self.joined + ANSWER_S

    def answers(self, agent: str) -> bool:
        """Whether an agent is present and gives signs of life."""
        return agent in self.statuses and agent not in self.silent

    @property
    def world_answers(self) -> bool:
        """Whether a world is present and gives signs of life."""
        return self.world is not None and names.WORLD not in self.silent

    @property
    def is_anyone_there(self) -> bool:
        """Whether an agent or a world answers."""
        return self.world_answers or any(map(self.answers, self.statuses))

    @property
    def is_stopped(self) -> bool:
        """Whether an emergency stop of all robots is engaged."""
        return bool(self.emergency)

    @property
    def shown(self) -> Scene | None:
        """The field that pages show: the scene of the world, or else of the robots."""
        if self.scene is None and self.robots is not None:
            return self.robots.scene
        return self.scene

    def doing(self) -> dict[str, tuple[str, str]]:
        """Return the mode and the active state of each agent.

        The mode is `SILENT_MODE` for an agent that does not answer, or whose robot's place is
        unknown.
        """
        lost = self.robots.lost if self.robots is not None else ()
        return _doing(self.statuses, self.silent, lost)


@lru_cache(maxsize=4)
def _in_order(names: frozenset[str]) -> tuple[str, ...]:
    return tuple(sorted(names, key=natural))


@while_same
def _doing(
    statuses: Mapping[str, Any], silent: Mapping[str, float], lost: Collection[str]
) -> dict[str, tuple[str, str]]:
    return {
        name: (SILENT_MODE, "") if name in silent or name in lost else (s.mode, state_shown(s))
        for name, s in statuses.items()
    }
