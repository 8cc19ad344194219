"""Keepaway worlds that have changed since the team was trained, and what is right there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from intentions import INTENTIONS, Edges, Intention

from hitab_world import Sensed
from keepaway_world.parameters import PAPER, KeepawayParameters
from keepaway_world.percept import OTHER_PLAYERS
from keepaway_world.world import KeepawayWorld


class Misread(KeepawayWorld):
    """A world whose keepers read the distances of other players with an offset, m."""

    offset = 0.0

    def percept(self, agent: str) -> Sensed:
        """Return what a keeper perceives now."""
        values, heard = super().percept(agent)
        for place in range(OTHER_PLAYERS, len(values), 2):
            values[place] = max(0.0, values[place] + self.offset)
        return values, heard


@dataclass(frozen=True)
class Change:
    """What has changed since the team was trained.

    Attributes:
        parameters: of the world; the keepers' behaviors know the old ones.
        offset: by which they read distances of players wrongly, m.
        edges: what is right now, where that is not what the lessons teach; see `search`.
    """

    parameters: KeepawayParameters = PAPER
    offset: float = 0.0
    edges: Edges = field(default_factory=dict)

    def world(self, parameters: KeepawayParameters, seed: int) -> KeepawayWorld:
        """Return a world after the change."""
        world = Misread(parameters, seed)
        world.offset = self.offset
        return world

    @property
    def intention(self) -> Intention:
        """What a person wants who knows of the change."""
        return adapted(self.edges)


def adapted(edges: Edges) -> Intention:
    """Return the lessons' intention with some other edges."""
    lessons = INTENTIONS["lessons"]
    plans = tuple(
        replace(plan, edges={name: edges.get(name, old) for name, old in plan.edges.items()})
        for plan in lessons.plans
    )
    return replace(lessons, plans=plans)


CHANGES: Mapping[str, Change] = {
    "takers twice as fast": Change(replace(PAPER, taker_speed=0.5), edges={"near": 3.5}),
    "ball slower": Change(replace(PAPER, ball_decay=0.92), edges={"near": 3.5}),
    "kicks 30 % weaker": Change(
        replace(PAPER, kick_rate=0.7 * PAPER.kick_rate), edges={"near": 3.5}
    ),
    "players read 1.5 m too far": Change(offset=1.5, edges={"near": 4.0}),
}

NEARER = Change(offset=-1.5, edges={"near": 1.2})
"""Takers are farther away than they look: keepers pass too early, which costs them little."""
