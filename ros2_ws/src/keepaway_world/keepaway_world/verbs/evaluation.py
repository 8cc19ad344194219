"""Plays episodes with trained or other keepers and sums up how long they keep the ball.

In lockstep each keeper has its own process and uses DDS, as in training; in-process the same
automata play the same episodes without ROS, many times faster.
"""

from __future__ import annotations

import contextlib
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hitab_bringup import (
    AgentDescription,
    Part,
    RunningSwarm,
    SwarmDescription,
    WorldDescription,
    open_library,
    part_of,
    players_of,
    plots,
    temporary_swarm,
    world_module,
    world_of,
)
from hitab_core import quantity
from hitab_world.evaluation import mean_and_error
from keepaway_world.verbs import paper

if TYPE_CHECKING:
    from hitab_client.console import Advance
    from hitab_world import EpisodeResult, World
    from hitab_world.inprocess import Player
    from keepaway_world.world import KeepawayWorld

    Game = tuple[World, Mapping[str, Player]]
    """A world in this process, and what plays its agents."""

PACES = ("lockstep", "inprocess")
TRAINED = "trained"
KEEPAWAY, RCSSSERVER = WORLDS = ("keepaway", "rcssserver")


@dataclass(frozen=True)
class Evaluation:
    """The results of all episodes, and what was evaluated."""

    behavior: str
    library: str
    library_digest: str
    pace: str
    seed: int
    parameters: Mapping[str, Any]
    played: Sequence[EpisodeResult]
    wall_s: float
    missed_deadlines: int = 0
    world: str = KEEPAWAY
    keepers: str = TRAINED

    def to_json(self) -> dict[str, Any]:
        """Return the figures as plain data."""
        cycles = sum(p.cycles for p in self.played)
        ended = Counter(p.ended for p in self.played)
        return {
            "episodes": len(self.played),
            "hold_time_s": mean_and_error([p.seconds for p in self.played]),
            "passes": mean_and_error([p.measures.get("passes", 0.0) for p in self.played]),
            "ended": {"out": ended.pop("out", 0), "taken": ended.pop("taken", 0), **ended},
            "cycles": cycles,
            "wall_s": round(self.wall_s, 3),
            "cycles_per_s": round(cycles / self.wall_s, 1) if self.wall_s else 0.0,
            "missed_deadlines": self.missed_deadlines,
            "keepers": self.keepers,
            "world": self.world,
            "pace": self.pace,
            "seed": self.seed,
            "behavior": self.behavior,
            "library": self.library,
            "library_digest": self.library_digest,
            "parameters": dict(self.parameters),
            "seconds_of_episodes": [p.seconds for p in self.played],
        }


def trained_keepers(
    library: Path | None,
    behavior: str,
    parameters: Mapping[str, Any],
    *,
    world: str = KEEPAWAY,
    seed: int = 1,
    domain: str = "",
) -> SwarmDescription:
    """Return a swarm of keepers that share a library, in a paused lockstep world.

    Their domain defaults to the library's; without a library it is ``keepaway``.
    """
    count = int(parameters.get("keepers", 3))
    domain = domain or (open_library(library).domain.name if library else KEEPAWAY)
    agents = tuple(
        AgentDescription(name, domain, start_from=library, behavior=behavior, process=name)
        for name in (f"keeper_{i + 1}" for i in range(count))
    )
    described = WorldDescription(
        world, world_module(world), "lockstep", seed=seed, paused=True, parameters=parameters
    )
    return SwarmDescription("evaluation", Path("evaluation"), agents, described)


def evaluate(
    library: Path,
    *,
    behavior: str,
    episodes: int,
    seed: int,
    pace: str,
    parameters: Mapping[str, Any],
    advance: Advance,
    world: str = KEEPAWAY,
) -> Evaluation:
    """Play episodes with the trained keepers of a library.

    Args:
        library: the library folder.
        behavior: the keepers' top-level behavior, of the library or hand-written.
        episodes: number of episodes.
        seed: of the run; the same seed gives the same episodes.
        pace: ``lockstep`` or ``inprocess``.
        parameters: of the game, and of the server.
        advance: called with the number of episodes played.
        world: ``keepaway``, the simulated world, or ``rcssserver``.

    Raises:
        LibraryError: if the library cannot be used, or has no such behavior.
        SwarmError: if a keeper or the world does not start, or stops answering.
    """
    trained = part_of(library, behavior)
    if pace == "inprocess":
        began = time.monotonic()
        with trained_game(trained, parameters, seed, world=world) as game:
            played = _play_inprocess(game, episodes, advance)
        wall, missed = time.monotonic() - began, 0
    else:
        swarm = trained_keepers(library, behavior, parameters, world=world, seed=seed)
        with temporary_swarm(swarm, progress=advance) as running:
            played, wall, missed = play_lockstep(running, episodes, seed, advance)
    return Evaluation(
        behavior, str(library), trained.digest, pace, seed, parameters, played, wall, missed, world
    )


def evaluate_offered(
    keepers: str, *, episodes: int, seed: int, parameters: Mapping[str, Any], advance: Advance
) -> Evaluation:
    """Play episodes with keepers that a package offers, in this process.

    Args:
        keepers: their name; see `keepaway_world.players`.
        episodes, seed, advance: as in `evaluate`.
        parameters: of the game; the defaults are those of the measurements on the real simulator:
            UT's takers and quantised sight.
    """
    began = time.monotonic()
    world, players = offered_game(keepers, parameters, seed)
    played = _play_inprocess((world, players), episodes, advance)
    figures, wall = world.parameters.as_dict(), time.monotonic() - began
    return Evaluation("", "", "", "inprocess", seed, figures, played, wall, keepers=keepers)


def offered_game(
    keepers: str, parameters: Mapping[str, Any], seed: int
) -> tuple[KeepawayWorld, Mapping[str, Player]]:
    """Return a world in this process, and the keepers of `evaluate_offered`.

    Raises:
        HitabError: if there is no such game.
    """
    from keepaway_world.parameters import variant
    from keepaway_world.players import KEEPERS, offered
    from keepaway_world.world import KeepawayWorld

    players = offered(KEEPERS, keepers)
    defaults = {"taker_policy": "reference", "sight": "quantised"}
    world = KeepawayWorld(variant("standard", **{**defaults, **parameters}), seed)
    return world, players(world)


@contextlib.contextmanager
def trained_game(
    trained: Part, parameters: Mapping[str, Any], seed: int, *, world: str = KEEPAWAY
) -> Iterator[Game]:
    """Yield a world in this process and trained keepers; see `evaluate`.

    Raises:
        HitabError: if there is no such game.
    """
    described = WorldDescription(world, world_module(world), seed=seed, parameters=parameters)
    with world_of(described) as made:
        yield made, players_of(made, dict.fromkeys(made.agents, trained))


def play_lockstep(
    running: RunningSwarm, episodes: int, seed: int, advance: Advance
) -> tuple[list[EpisodeResult], float, int]:
    """Play episodes with a running swarm.

    Returns:
        The episodes, the elapsed seconds, and the number of late answers of agents.
    """
    from hitab_world import EpisodeResult

    world = running.world
    began = time.monotonic()
    messages = world.play(
        episodes, seed, progress=lambda done: advance(done, episodes, "playing episodes")
    )
    wall = time.monotonic() - began
    # The world pauses by itself after the last one and reports it.
    running.link.spin_until(
        lambda: world.status is not None and world.status.episodes_left == 0, 3.0
    )
    missed = world.wait().missed_deadlines
    played = []
    for m in messages:
        measures = dict(zip(m.measure_names, m.measures, strict=True))
        played.append(EpisodeResult(m.number, m.seed, m.cycles, m.seconds, m.ended, measures))
    return played, wall, missed


def _play_inprocess(game: Game, episodes: int, advance: Advance) -> list[EpisodeResult]:
    from hitab_world.evaluation import Game, play_alike

    played = []
    for (result,) in play_alike([Game(*game)], episodes):
        played.append(result)
        advance(len(played), episodes, "playing episodes")
    return played


def draw_episode_lengths(evaluation: Evaluation, path: Path) -> None:
    """Draw the lengths of the episodes, with the paper's mean and ours."""
    plots.draw_measures(
        {"length of the episode, s": {"ours": [one.seconds for one in evaluation.played]}},
        f"{evaluation.behavior}: {quantity(len(evaluation.played), 'episode')}, seed "
        f"{evaluation.seed}, takers at {evaluation.parameters.get('taker_speed', 0.25):g} of full "
        "speed",
        path,
        {"the paper": paper.HOLD_TIME_S},
    )
