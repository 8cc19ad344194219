"""A world that nobody here wrote: three agents of mpe2 spread over three landmarks.

See docs/worlds.md; research/mpe2_team.py trains the team and compares it with others.
"""

# ruff: noqa: D101, D102, D103 - as short as a file of one's own

from math import dist, hypot

from mpe2 import simple_spread_v3

from hitab_core import behavior, feature
from hitab_world import Entity, GymnasiumWorld


class Spread(GymnasiumWorld):
    agents = 3
    size = (4.0, 4.0)

    def environment(self):
        return simple_spread_v3.parallel_env(N=self.agents)

    def draw(self):
        world = self.env.unwrapped.world
        for name, agent in zip(self.names, world.agents, strict=True):
            yield Entity(name, "agent", *agent.state.p_pos, radius=agent.size)
        for number, landmark in enumerate(world.landmarks, 1):
            yield Entity(f"landmark_{number}", "landmark", *landmark.state.p_pos, radius=0.05)


def places(percept):
    """Return where landmarks are, the nearest first, and teammates, as seen from the agent."""
    pairs = list(zip(percept[::2], percept[1::2], strict=True))  # velocity and position are first
    team = len(percept) // 6
    landmarks = sorted(pairs[2 : 2 + team], key=lambda pair: hypot(*pair))
    return landmarks, pairs[2 + team : 1 + 2 * team]


def lead(percept, rank):
    landmarks, mates = places(percept)
    return min(dist(landmarks[rank], mate) for mate in mates) - hypot(*landmarks[rank])


def go(percept, rank):
    x, y = (to - 0.3 * speed for to, speed in zip(places(percept)[0][rank], percept, strict=False))
    if max(abs(x), abs(y)) < 0.05:
        return [0]
    if abs(x) > abs(y):
        return [2 if x > 0.0 else 1]
    return [4 if y > 0.0 else 3]


@feature
def Lead(percept):
    """By how much the agent is nearer to its nearest landmark than any teammate, m."""
    return lead(percept, 0)


@feature
def LeadToNext(percept):
    """By how much the agent is nearer to the next landmark than any teammate, m."""
    return lead(percept, 1)


@behavior
def GoToNearest(percept):
    return go(percept, 0)


@behavior
def GoToNext(percept):
    return go(percept, 1)


@behavior
def GoToLast(percept):
    return go(percept, -1)
