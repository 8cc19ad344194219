"""Keepers as several tests use them: swarms of them, and what they play without ROS."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from hitab_bringup import SwarmDescription
from hitab_bringup.casting import Cast
from hitab_bringup.evaluation import games_of, play_alike
from hitab_bringup.libraries.opened_library import open_library
from hitab_bringup.processes.bringing_up import RunningSwarm
from hitab_bringup.swarm_files.swarm_options import described_swarm
from hitab_client import SwarmError
from hitab_client.runs.run_folder import libraries_of
from hitab_client.runs.shipped import shipped
from hitab_core import BehaviorLibrary
from hitab_core.operations import DiscardTraining, LoadLibrary, Perform
from hitab_world import EpisodeResult


def trained_keepers(
    library: Path | None,
    behavior: str,
    parameters: Mapping[str, Any],
    *,
    seed: int = 1,
    domain: str = "",
    count: int = 3,
) -> SwarmDescription:
    """Return keepers in processes of their own, in a paused lockstep world.

    Their domain defaults to the library's; without a library it is ``keepaway``.
    """
    described = described_swarm("keepaway", None, pace="lockstep", paused=True)
    domain = domain or (open_library(library).domain.name if library else "keepaway")
    agents = tuple(
        replace(agent, domain=domain, start_from=library, behavior=behavior)
        for agent in described.agents[:count]
    )
    swarm = replace(described, name="evaluation", file=Path("evaluation"), agents=agents)
    return swarm.with_world(seed=seed, parameters=dict(parameters))


def assert_taught_what_is_shipped(folder: Path, library: str, behavior: str) -> None:
    """Check the examples of a behavior, but for the numbers of the world's cycles."""
    there = open_library(shipped("libraries", library))
    taught, known = (
        [(e.state, e.features, e.next_state, e.kind) for e in lib.load()[behavior].examples]
        for lib in (BehaviorLibrary(folder, there.domain), there)
    )
    assert taught == known, behavior


def played(swarm: SwarmDescription, episodes: int) -> list[EpisodeResult]:
    """Return the episodes that agents play in this process, as `hitab evaluate` does."""
    with games_of(swarm, [Cast(swarm).parts()]) as games:
        return [result for (result,) in play_alike(games, episodes)]


def begin_anew(running: RunningSwarm) -> RunningSwarm:
    """Have nothing trained, learned or performed, and the world paused, in lockstep."""
    agents, world = running.agents, running.world
    shutil.rmtree(running.folder.path / "generations", ignore_errors=True)
    for name, library in libraries_of(running.folder.path).items():
        agents.await_agent(name, 60.0)
        try:
            agents.do(name, DiscardTraining())
        except SwarmError as refused:
            if "no training to discard" not in str(refused):
                raise
        agents.do(name, Perform())
        shutil.rmtree(library)
        library.mkdir()
        agents.do(name, LoadLibrary())
    world.control("pace", pace="lockstep", factor=1.0)
    world.shown(world.control("pause"))
    for name in world.snapshot("list").names:
        world.snapshot("delete", name)
    return running
