"""Agents on a line: a world and the words of its agents in one file; see docs/worlds.md."""

# ruff: noqa: D101, D102, D103 - as short as a file of one's own

from random import Random

from hitab_core import behavior, feature
from hitab_world import Entity, Measure, Simulation


class Corridor(Simulation):
    measures = (Measure("distance"),)

    def reset(self, seed):
        random = Random(seed)
        self.x = {name: random.uniform(-3.0, 3.0) for name in self.names}
        self.gone = 0.0
        return self.percepts()

    def step(self, actions):
        for name, action in actions.items():
            self.x[name] += 0.1 * sum(action)
            self.gone += abs(0.1 * sum(action))
        if self.gone > 4.0:
            self.ended = "far"
        return self.percepts()

    def percepts(self):
        return {name: [x] for name, x in self.x.items()}

    def draw(self):
        return [Entity(name, "agent", x, 0.0, radius=0.2) for name, x in self.x.items()]

    def measured(self):
        return {"distance": self.gone}


@feature
def Position(percept):
    return percept[0]


@behavior
def Left(percept):
    return [-1.0]


@behavior
def Right(percept):
    return [1.0]
