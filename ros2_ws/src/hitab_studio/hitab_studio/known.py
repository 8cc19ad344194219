"""What the link's thread tells the pages: frozen, so that two threads may look at it.

A message of ROS that was received is never changed by anybody; all else here is immutable.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from hitab_studio.finding import Target
from hitab_studio.learned import NOTHING
from hitab_studio.scene import Scene, state_shown
from hitab_studio.situations import Moments
from hitab_studio.watching import Watched


@dataclass(frozen=True)
class Known:
    """All that is known of a swarm at one moment.

    Attributes:
        target: which swarm is meant; None before anything was looked for.
        revision: raised with each change that pages show.
        world: the last `WorldStatus`.
        scene: the last moment.
        statuses: the last `AgentStatus` of each agent, by name.
        gone: agents whose node has gone.
        groups: the last `CommanderStatus` of each commander, by name.
        watched: more about those that are looked at, by name.
        moments: in which examples were recorded.
        recording: where a run is being recorded to; "" while none is.
        recorded: how many messages it has.
    """

    target: Target | None = None
    revision: int = 0
    world: Any = None
    scene: Scene | None = None
    statuses: Mapping[str, Any] = field(default_factory=lambda: NOTHING)
    gone: frozenset[str] = frozenset()
    groups: Mapping[str, Any] = field(default_factory=lambda: NOTHING)
    watched: Mapping[str, Watched] = field(default_factory=lambda: NOTHING)
    moments: Moments = field(default_factory=Moments)
    recording: str = ""
    recorded: int = 0

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


@dataclass(frozen=True)
class Trouble:
    """Something that went wrong in the link's thread.

    Attributes:
        text: what, for people.
        session: the page that caused it; "" if that is not known.
        agent: pages that look at it caused it; "" if that is not known.
    """

    text: str
    session: str = ""
    agent: str = ""


def natural(name: str) -> tuple[str, int, str]:
    """Return what sorts keeper_2 before keeper_10."""
    head = name.rstrip("0123456789")
    return (head, int(name[len(head) :] or 0), name)
