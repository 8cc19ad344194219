"""A domain whose bodies write down what they begin, so that a test sees what has become of orders.

The folder to write into is in the environment variable ``CHAOS_FOLDER``.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hitab_core.automaton import START, Automaton
from hitab_core.domain import BasicBehavior, Domain, Feature
from hitab_core.example import Example
from hitab_core.learning.transition_learning import learn_transitions
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.use import Use

BASICS = ("Dig", "Haul", "Rest")
TRAINED = {"Digging": "Dig", "Hauling": "Haul", "Resting": "Rest"}
"""What each trained behavior begins with, and stays in."""


class Body:
    """Perceives one number; writes down which basic behaviors are begun."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.values: Sequence[float] = ()

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take a percept."""
        self.values = values

    def act(self) -> tuple[Sequence[float], str]:
        """Do nothing to the world."""
        return (0.0,), ""

    def begin(self, behavior: str) -> None:
        """Write down that a behavior is begun, and by which process."""
        with (Path(os.environ["CHAOS_FOLDER"]) / f"{self.name}.log").open("a") as log:
            log.write(f"{os.getpid()} {behavior}\n")


def _begins(name: str) -> Any:
    return lambda body: body.begin(name)


DOMAIN = Domain.of(
    "chaos",
    "1",
    Body,
    behaviors=[BasicBehavior(name, start=_begins(name)) for name in BASICS],
    features=[Feature("Level", lambda body: body.values[0])],
)


def make_library(folder: Path) -> None:
    """Save the trained behaviors."""
    level = Use("Level")
    library = BehaviorLibrary(folder, DOMAIN)
    for name, basic in TRAINED.items():
        examples = (Example(START, (0.0,), basic, number=1, command=1),)
        learned = learn_transitions(examples, [DOMAIN.features["Level"].scale])
        library.save(Automaton(name, (Use(basic),), (level,), learned, (), examples))


class World:
    """A world in which nothing happens but that agents perceive a level."""

    name = "chaos"
    cycle_seconds = 0.1
    size = (10.0, 10.0)
    looks: Mapping[str, Any] = {}
    ended = ""
    refused: Mapping[str, str] = {}

    def __init__(self, agents: int, seed: int) -> None:
        self.agents = tuple(f"worker_{i + 1}" for i in range(agents))
        self.seed = seed
        self.episode = self.cycle = self.episode_cycle = 0

    def reset(self, episode: int | None = None, seed: int | None = None) -> None:
        """Go on: there is only one episode."""

    def percept(self, agent: str) -> tuple[list[float], list[str]]:
        """Return the level."""
        return [float(self.cycle % 100)], []

    def step(self, actions: Mapping[str, Any]) -> str | None:
        """Let a cycle pass."""
        self.cycle += 1
        self.episode_cycle += 1
        return None

    def entities(self) -> list[Any]:
        """Return nothing to be seen."""
        return []


def main() -> None:
    """Run the world as a process."""
    import sys

    from hitab_ros.spinning import run
    from hitab_world.world_node import run_world

    def make(node: Any, seed: int) -> Any:
        return World(node.declare_parameter("parameters.workers", 1).value, seed)

    sys.exit(run(lambda spinning: run_world(make, spinning)))


if __name__ == "__main__":
    main()
