"""A world and a domain that cost next to nothing, so that a benchmark measures the swarm.

Agents are points on a field that walk and turn. Each performs a trained automaton of two levels.

    python research/plain_world.py --ros-args -r __ns:=/world -p parameters.agents:=100
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from rclpy.node import Node

from hitab_core.automaton import START, Automaton
from hitab_core.domain import BasicBehavior, Domain, Feature, FeatureKind
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.term import Term
from hitab_world.node.world_node import run_world
from hitab_world.world import Action, Entity, EpisodeResult, Look, Placement, Sensed, WorldError

SIZE = 200.0
CYCLE_S = 0.1


class PlainBody:
    """Perceives x, y and heading; walks and turns."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.values: Sequence[float] = ()
        self.action = [0.0, 0.0]

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take this cycle's percept."""
        self.values = values
        self.action = [0.0, 0.0]

    def act(self) -> tuple[Sequence[float], str]:
        """Return how fast to walk and by what angle to turn."""
        return self.action, ""


def _does(walk: float, turn: float) -> Any:
    def pulse(body: PlainBody) -> None:
        body.action = [walk, turn]

    return pulse


def _column(index: int) -> dict[str, Any]:
    def read(body: PlainBody) -> float:
        return body.values[index]

    return {"read": read}


X = Feature("X", **_column(0), unit="m")
HEADING = Feature("Heading", **_column(2), kind=FeatureKind.TOROIDAL, unit="rad")
FEATURES = (X, Feature("Y", **_column(1), unit="m"), HEADING)
BEHAVIORS = (
    BasicBehavior("Walk", _does(1.0, 0.0)),
    BasicBehavior("Turn", _does(0.0, 0.3)),
    BasicBehavior("Wait", _does(0.0, 0.0)),
)


def _tree(feature: Feature, *examples: tuple[float, str]) -> TransitionTree:
    values, labels = zip(*examples, strict=True)
    return TransitionTree([feature.scale]).fit([[value] for value in values], list(labels))


PATROL = Automaton(
    "Patrol",
    (Term("Walk"), Term("Turn")),
    (Term("Heading"),),
    {
        START: _tree(HEADING, (0.0, "Walk")),
        "Walk": _tree(HEADING, *[(a, "Walk") for a in (0.0, 1.0, 2.0)], (0.5, "Turn")),
        "Turn": _tree(HEADING, (0.3, "Turn"), (0.6, "Walk"), (2.5, "Turn"), (3.0, "Walk")),
    },
)
EXPLORE = Automaton(
    "Explore",
    (Term("Patrol"), Term("Wait")),
    (Term("X"),),
    {
        START: _tree(X, (0.0, "Patrol")),
        "Patrol": _tree(X, (-50.0, "Patrol"), (0.0, "Wait"), (50.0, "Patrol")),
        "Wait": _tree(X, (-50.0, "Patrol"), (0.0, "Patrol"), (50.0, "Patrol")),
    },
)
DOMAIN = Domain.of(
    "plain", "1", PlainBody, behaviors=BEHAVIORS, features=FEATURES, automata=(PATROL, EXPLORE)
)


class PlainWorld:
    """Points that walk and turn on a field without walls; see `hitab_world.world.World`."""

    name = "plain"
    cycle_seconds = CYCLE_S
    looks: Mapping[str, Look] = {}
    size = (SIZE, SIZE)

    def __init__(self, agents: int, seed: int = 0) -> None:
        self.agents = tuple(f"ant_{i + 1}" for i in range(agents))
        self.seed = seed
        self.episode = self.cycle = self.episode_cycle = 0
        self.ended = ""
        self.refused: Mapping[str, str] = {}
        self._index = {name: i for i, name in enumerate(self.agents)}
        self.reset(0)

    def reset(self, episode: int | None = None, seed: int | None = None) -> None:
        """Begin an episode with all agents at new positions."""
        self.seed = self.seed if seed is None else seed
        self.episode = self.episode + 1 if episode is None else episode
        self.episode_cycle = 0
        rng = np.random.default_rng([self.seed, self.episode])
        self._states = rng.uniform(-1.0, 1.0, (len(self.agents), 3)) * (SIZE / 2, SIZE / 2, 3.0)
        self._rows = self._states.tolist()

    def percept(self, agent: str) -> Sensed:
        """Return position and heading."""
        return self._rows[self._index[agent]], []

    def step(self, actions: Mapping[str, Action]) -> str | None:
        """Walk and turn."""
        moves = np.zeros((len(self.agents), 2))
        for agent, (values, _) in actions.items():
            if len(values):
                moves[self._index[agent]] = values
        states = self._states
        states[:, 2] = (states[:, 2] + moves[:, 1] + math.pi) % (2 * math.pi) - math.pi
        along = moves[:, 0] * CYCLE_S
        states[:, 0] += along * np.cos(states[:, 2])
        states[:, 1] += along * np.sin(states[:, 2])
        self._rows = states.tolist()
        self.cycle += 1
        self.episode_cycle += 1
        return None

    def entities(self) -> list[Entity]:
        """Return all agents."""
        return [
            Entity(name, "ant", x, y, heading, radius=0.2)
            for name, (x, y, heading) in zip(self.agents, self._rows, strict=True)
        ]

    def place(self, placements: Iterable[Placement], *, new_episode: bool = False) -> None:
        """Refuse: nothing can be placed here."""
        raise WorldError("the plain world is a benchmark's; nothing can be placed in it")

    def snapshot(self) -> dict[str, Any]:
        """Return all positions."""
        return {"states": self._states.tolist(), "cycle": self.cycle}

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Restore all positions."""
        self._states = np.array(snapshot["states"])
        self._rows = self._states.tolist()

    def result(self) -> EpisodeResult:
        """Return how long it has lasted."""
        cycles = self.episode_cycle
        return EpisodeResult(self.episode, self.seed, cycles, cycles * CYCLE_S, self.ended)


def make_world(node: Node, seed: int) -> PlainWorld:
    """Make the world that the node's parameters describe."""
    return PlainWorld(node.declare_parameter("parameters.agents", 10).value, seed)


if __name__ == "__main__":
    run_world(make_world)
