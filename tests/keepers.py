"""Keepers as several tests use them: swarms of them, and what they play without ROS."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from hitab_bringup import SwarmDescription
from hitab_bringup.casting import Cast
from hitab_bringup.evaluation import games_of, play_alike
from hitab_bringup.libraries.opened_library import open_library
from hitab_bringup.swarm_files.swarm_options import described_swarm
from hitab_world import EpisodeResult


def trained_keepers(
    library: Path | None,
    behavior: str,
    parameters: Mapping[str, Any],
    *,
    seed: int = 1,
    domain: str = "",
) -> SwarmDescription:
    """Return keepers in processes of their own, in a paused lockstep world.

    Their domain defaults to the library's; without a library it is ``keepaway``.
    """
    described = described_swarm("keepaway", None, pace="lockstep", paused=True)
    domain = domain or (open_library(library).domain.name if library else "keepaway")
    agents = tuple(
        replace(agent, domain=domain, start_from=library, behavior=behavior)
        for agent in described.agents
    )
    swarm = replace(described, name="evaluation", file=Path("evaluation"), agents=agents)
    return swarm.with_world(seed=seed, parameters=dict(parameters))


def played(swarm: SwarmDescription, episodes: int) -> list[EpisodeResult]:
    """Return the episodes that agents play in this process, as `hitab evaluate` does."""
    with games_of(swarm, [Cast(swarm).parts()]) as games:
        return [result for (result,) in play_alike(games, episodes)]
