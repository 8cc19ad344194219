"""Compares a tick of the four-level Keepaway automaton with one of a py_trees tree.

Both decide for the same keeper on the same percepts, recorded from a game, by the same features
and basic behaviors. The tree is what one would write by hand for the same job, with the learned
thresholds. Reading the percept and writing the action are not counted; they are the same for both.

    scripts/python research/tick.py --json tick.json
"""

from __future__ import annotations

import math
import random
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import py_trees
import typer
from report import tell

from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.repertoire import Repertoire
from hitab_core.running import RunContext, performance
from hitab_core.running.feature_cache import FeatureCache
from hitab_core.term import Term
from hitab_world.inprocess import cycle, perform
from keepaway_world.body import KeeperBody
from keepaway_world.domain import DOMAIN
from keepaway_world.world import KeepawayWorld

Percepts = list[tuple[list[float], list[str]]]


def record(repertoire: Repertoire, count: int) -> Percepts:
    """Return what keeper_1 perceives in a game of trained keepers."""
    world = KeepawayWorld(seed=11)
    players = perform(world, repertoire, "Keepaway")
    percepts: Percepts = []
    while len(percepts) < count:
        if world.ended or not percepts:
            world.reset()
            for player in players.values():
                player.begin(world.seed, world.episode)
        percepts.append(world.percept("keeper_1"))
        cycle(world, players)
    return percepts


class Condition(py_trees.behaviour.Behaviour):
    """Succeeds if a test of the body holds."""

    def __init__(self, name: str, test: Callable[[], bool]) -> None:
        super().__init__(name)
        self.test = test

    def update(self) -> py_trees.common.Status:
        """Return success or failure."""
        return py_trees.common.Status.SUCCESS if self.test() else py_trees.common.Status.FAILURE


class Act(py_trees.behaviour.Behaviour):
    """Pulses a basic behavior; runs forever, or succeeds at once if the behavior is one-shot."""

    def __init__(self, name: str, body: KeeperBody) -> None:
        super().__init__(name)
        basic = DOMAIN.behaviors[name]
        self.pulse, self.body = basic.pulse, body
        self.status_after = (
            py_trees.common.Status.SUCCESS if basic.one_shot else py_trees.common.Status.RUNNING
        )

    def update(self) -> py_trees.common.Status:
        """Pulse once."""
        self.pulse(self.body)
        return self.status_after


def keepaway_tree(body: KeeperBody) -> py_trees.trees.BehaviourTree:
    """Return a behavior tree that does what the Keepaway automaton does."""
    in_control = {"of the ball": False}

    def reads(name: str, *targets: str) -> Callable[[], float]:
        feature = DOMAIN.features[name]
        resolvers = [DOMAIN.targets[t].resolve for t in targets]
        return lambda: feature.read(body, *(resolve(body) for resolve in resolvers))

    distance, taker = reads("DistanceTo", "ball"), reads("DistanceTo", "closest_taker")
    direction, kickable = reads("DirectionTo", "ball"), reads("BallIsKickable")
    yelled, closer = reads("IWasYelledAt"), reads("ATeammateIsCloserToBall")

    def sequence(name: str, *children: Any) -> py_trees.composites.Sequence:
        return py_trees.composites.Sequence(name, memory=False, children=list(children))

    def selector(name: str, *children: Any) -> py_trees.composites.Selector:
        return py_trees.composites.Selector(name, memory=False, children=list(children))

    def controls() -> bool:
        if yelled() or not closer():
            in_control["of the ball"] = True
        return in_control["of the ball"]

    def passed() -> bool:
        in_control["of the ball"] = False
        return True

    approach = selector(
        "ApproachBall",
        sequence("far", Condition("d > 5", lambda: distance() > 5.0), Act("GoFast", body)),
        sequence("midway", Condition("d > 2.5", lambda: distance() > 2.5), Act("GoMedium", body)),
        sequence("near", Condition("d > 1", lambda: distance() > 1.0), Act("GoSlow", body)),
        Act("Stop", body),
    )
    goto = selector(
        "GotoBall",
        sequence(
            "ahead", Condition("|a| < 9°", lambda: abs(direction()) < math.radians(9)), approach
        ),
        Act("TurnToBall", body),
    )
    control = selector(
        "ControlBall",
        sequence(
            "with the ball",
            Condition("kickable", lambda: bool(kickable())),
            selector(
                "wait or pass",
                sequence(
                    "pass",
                    Condition("taker near", lambda: taker() <= 2.5),
                    Act("Pass", body),
                    Condition("done", passed),
                ),
                Act("Stop", body),
            ),
        ),
        goto,
    )
    root = selector(
        "Keepaway",
        sequence("in control", Condition("in control", controls), control),
        Act("GetOpen", body),
    )
    tree = py_trees.trees.BehaviourTree(root)
    tree.setup()
    return tree


def microseconds(body: KeeperBody, percepts: Percepts, tick: Callable[[], object]) -> float:
    """Return the time of a tick, without that of taking percepts in and giving actions out."""

    def play(ticks: bool) -> float:
        began = time.perf_counter()
        for values, heard in percepts:
            body.sense(values, heard)
            if ticks:
                tick()
            body.act()
        return time.perf_counter() - began

    return (play(True) - play(False)) / len(percepts) * 1e6


def main(
    ticks: Annotated[int, typer.Option(help="Ticks in each measurement.")] = 5000,
    turns: Annotated[int, typer.Option(help="Number of turns of each of the two.")] = 7,
    library: Annotated[Path | None, typer.Option(help="Folder of a trained library.")] = None,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
) -> None:
    """Compare a tick of the Keepaway automaton with one of an equivalent py_trees tree."""
    from hitab_client.runs.shipped import shipped

    trained = BehaviorLibrary(library or shipped("libraries", "keepaway"), DOMAIN)
    repertoire = Repertoire(DOMAIN, trained.load())
    percepts = record(repertoire, ticks)

    body = KeeperBody("keeper_1")
    feature_cache = FeatureCache(body, DOMAIN)
    context = RunContext(repertoire, body, feature_cache, random.Random(1).random)
    running = performance(context, Term("Keepaway"))
    running.start()

    def tick_automaton() -> None:
        feature_cache.forget()
        running.tick()

    other = KeeperBody("keeper_1")
    tree = keepaway_tree(other)
    hitab, trees = [], []
    for _ in range(turns):
        hitab.append(microseconds(body, percepts, tick_automaton))
        trees.append(microseconds(other, percepts, tree.tick))
    tell(
        f"One tick of Keepaway, features included, medians of {turns} turns of {ticks} ticks",
        {
            "hitab_us": median(hitab),
            "py_trees_us": median(trees),
            "hitab_of_py_trees": median(a / b for a, b in zip(hitab, trees, strict=True)),
        },
        json,
    )


if __name__ == "__main__":
    typer.run(main)
