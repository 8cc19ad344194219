"""Everything that is known of a swarm at the moment.

Written by the thread of the link, read by the pages: values are replaced, never changed, so that
a reader sees either the old one or the new one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from hitab_studio.finding import Target
from hitab_studio.scene import Palette, Scene, state_shown
from hitab_studio.situations import Situations
from hitab_studio.watching import Watched


@dataclass
class Store:
    """What is known.

    Attributes:
        target: which swarm is meant; None before anything was looked for.
        version: raised with each change that pages show.
        world: the last `WorldStatus`.
        scene: the last moment.
        statuses: the last `AgentStatus` of each agent, by name.
        gone: agents whose node has gone.
        groups: the last `CommanderStatus` of each commander, by name.
        watched: more about those that are looked at, by name.
        palette: the colors of states.
        placements: where things were before they were placed, newest last, for undoing that.
        snapshots: names of the snapshots that the world keeps.
        recording: where a run is being recorded to; "" while none is.
        recorded: how many messages it has.
    """

    target: Target | None = None
    version: int = 0
    world: Any = None
    scene: Scene | None = None
    statuses: Mapping[str, Any] = field(default_factory=dict)
    gone: frozenset[str] = frozenset()
    groups: Mapping[str, Any] = field(default_factory=dict)
    watched: Mapping[str, Watched] = field(default_factory=dict)
    palette: Palette = field(default_factory=Palette)
    situations: Situations = field(default_factory=Situations)
    placements: list[dict[str, dict[str, float]]] = field(default_factory=list)
    snapshots: tuple[str, ...] = ()
    recording: str = ""
    recorded: int = 0

    def touch(self) -> None:
        """Say that something has changed."""
        self.version += 1

    def reset(self, target: Target) -> None:
        """Forget a swarm: another one is meant from now on, or another start of it."""
        self.target = target
        self.world = self.scene = None
        self.statuses, self.groups, self.watched = {}, {}, {}
        self.gone = frozenset()
        self.situations = Situations()
        self.placements.clear()
        self.snapshots = ()
        self.touch()

    @property
    def agents(self) -> list[str]:
        """Names of the agents that there are or should be."""
        expected = self.target.agents if self.target is not None else ()
        return sorted({*self.statuses, *expected}, key=natural)

    def answers(self, agent: str) -> bool:
        """Whether an agent is there."""
        return agent in self.statuses and agent not in self.gone

    def doing(self) -> dict[str, tuple[str, str]]:
        """Return the mode and the active state of each agent."""
        return {name: (s.mode, state_shown(s.active_path)) for name, s in self.statuses.items()}


def natural(name: str) -> tuple[str, int, str]:
    """Return what sorts keeper_2 before keeper_10."""
    head = name.rstrip("0123456789")
    return (head, int(name[len(head) :] or 0), name)
