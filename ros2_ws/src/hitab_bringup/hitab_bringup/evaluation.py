"""Evaluation of a swarm: episodes that a cast plays without ROS, and comparison of two casts.

The world and the players of its agents are in this process.
"""

from __future__ import annotations

import importlib
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from graphlib import TopologicalSorter
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from hitab_bringup.casting import CastMember
from hitab_bringup.swarm_files.swarm_description import (
    CommanderDescription,
    SwarmDescription,
    WorldDescription,
)
from hitab_bringup.swarm_files.swarm_options import described_swarm
from hitab_client import DescriptionError
from hitab_client.measures import Estimate, estimate
from hitab_commander import Commander, HierarchyPlayers, Member
from hitab_core import BehaviorLibrary, HitabError, has, some
from hitab_core.library.yaml_places import read_yaml
from hitab_world import MORE, SECONDS, EpisodeResult, Measure, World
from hitab_world.inprocess import AutomatonPlayer, Between, Player, play
from hitab_world.node.ros_parameters import GivenParameters

SIDES = ("evaluated", "against")
"""Names of two compared casts."""


class GameSetup(NamedTuple):
    """A world in this process with its players.

    Attributes:
        between: called between the percepts and the actions of a cycle, for commanders.
    """

    world: World
    players: Mapping[str, Player]
    between: Between | None = None


def evaluated_swarm(swarm: str, seed: int, parameters: Sequence[str]) -> SwarmDescription:
    """Return the description of a swarm for episodes without ROS.

    Args:
        swarm: a swarm description, or the name of a shipped one.
        seed: random seed of the run.
        parameters: parameters of the world, as ``NAME=VALUE``, instead of the swarm's own.

    Raises:
        HitabError: if the swarm has no world, or a parameter has another form.
    """
    described = described_swarm(swarm, None)
    world = described.with_world().world  # raises without a world
    assert world is not None
    return described.with_world(
        seed=seed, parameters={**world.parameters, **figures_in(parameters)}
    )


def figures_in(texts: Sequence[str]) -> dict[str, Any]:
    """Return the parameters of a world from ``NAME=VALUE`` texts, with values as in YAML.

    Raises:
        HitabError: if a text has another form.
    """
    figures = {}
    for text in texts:
        name, _, value = text.partition("=")
        if not (name and value):
            raise HitabError(f'"{text}" is not NAME=VALUE, such as takers=3')
        figures[name] = read_yaml(value, "--parameter").value
    return figures


@contextmanager
def world_of(described: WorldDescription) -> Iterator[World]:
    """Yield the world of a description.

    Raises:
        HitabError: if one of the parameters is invalid.
    """
    module = importlib.import_module(described.module)
    if not hasattr(module, "make_world"):
        raise DescriptionError(
            f"{described.module} has no make_world(node, seed), which makes a world without ROS"
        )
    made: World = module.make_world(GivenParameters(described.parameters), described.seed)
    with ExitStack() as leaving:
        if close := getattr(made, "close", None):
            leaving.callback(close)
        yield made


def players_of(world: World, parts: Mapping[str, CastMember]) -> dict[str, Player]:
    """Return the players of a world's agents, without agents that are not in the world.

    Raises:
        DescriptionError: if the world has none of the agents.
    """

    def time() -> float:
        return world.episode_cycle * world.cycle_seconds

    return {
        name: AutomatonPlayer(part.repertoire, part.behavior, name, time=time)
        for name, part in _there(world, parts).items()
        if part.behavior is not None
    }


def _there(world: World, parts: Mapping[str, CastMember]) -> dict[str, CastMember]:
    cast = {name: parts[name] for name in world.agents if name in parts}
    if not cast:
        raise DescriptionError(f"the world has none of {some([*parts])} {has(world.agents)}")
    return cast


@contextmanager
def games_of(
    swarm: SwarmDescription, casts: Sequence[Mapping[str, CastMember]]
) -> Iterator[list[GameSetup]]:
    """Yield a game for each cast of a swarm; all worlds begin in the same way.

    Raises:
        HitabError: if a game is impossible.
    """
    described = swarm.with_world().world  # raises without a world
    assert described is not None
    with ExitStack() as stack:
        worlds = [stack.enter_context(world_of(described)) for _ in casts]
        yield [
            _commanded(world, parts, swarm.commanders, stack)
            for world, parts in zip(worlds, casts, strict=True)
        ]


def _commanded(
    world: World,
    parts: Mapping[str, CastMember],
    commanders: Sequence[CommanderDescription],
    leaving: ExitStack,
) -> GameSetup:
    """Return a game in which the commanders with a behavior give orders."""
    by_name = {one.name: one for one in commanders if one.name in parts}
    if not by_name:
        return GameSetup(world, players_of(world, parts))
    agents = _there(world, parts)
    playing, made = {*agents}, []
    for name in TopologicalSorter(
        {n: [*c.subordinates] for n, c in by_name.items()}
    ).static_order():
        one = by_name.get(name)
        group = tuple(sub for sub in one.subordinates if sub in playing) if one else ()
        if one is None or not group:
            continue  # an agent, or a commander without members in this world
        playing.add(name)
        behavior = str(parts[name].behavior or "")
        library = _library(parts[name], leaving)
        roles, asks = one.subordinates, one.asks_position
        made.append(Commander(name, one.kind, library, behavior, group, roles, asks))
    members = [
        Member(name, _library(part, leaving), str(part.behavior or ""))
        for name, part in agents.items()
    ]
    hierarchy = HierarchyPlayers(members, made, world.cycle_seconds)
    return GameSetup(world, hierarchy.players, hierarchy.confer)


def _library(part: CastMember, leaving: ExitStack) -> BehaviorLibrary:
    """Return a cast member's library; a copy if versions are chosen or there is no library."""
    domain = part.repertoire.domain
    if part.opened is not None and not part.versions:
        return part.opened
    folder = leaving.enter_context(TemporaryDirectory(prefix="hitab-"))
    made = BehaviorLibrary(folder, domain)
    if part.opened is not None:
        made.install(part.opened.texts())
        for name in part.versions:
            made.save(part.repertoire.automata[name])
    return made


def measures_of(world: World, results: Sequence[EpisodeResult]) -> Sequence[Measure]:
    """Return a world's declared measures, or those of its results, with more as better."""
    names = {name for result in results for name in result.measures}
    undeclared = (Measure(SECONDS, "s"), *map(Measure, sorted(names)))
    return getattr(world, "measures", ()) or undeclared


def play_alike(
    games: Sequence[GameSetup], episodes: int, *, longest: float = 0.0
) -> Iterator[tuple[EpisodeResult, ...]]:
    """Play the same episodes in each game; yield the results of each episode, by game.

    Args:
        games: games with worlds of the same seed and parameters.
        episodes: number of episodes.
        longest: longest episode, simulated seconds; 0 for no limit.
    """
    for number in range(episodes):
        yield tuple(
            play(
                *(game.world, game.players),
                between=game.between,
                first=number,
                cycles_max=math.ceil(longest / game.world.cycle_seconds) or None,
            )[0]
            for game in games
        )


@dataclass(frozen=True)
class Comparison:
    """A measure of the same episodes, in one game or in two.

    Attributes:
        measure: the compared measure.
        values: values of the measure in the episodes, by game.
    """

    measure: Measure
    values: Sequence[Sequence[float]]

    @classmethod
    def of(cls, measure: Measure, played: Sequence[tuple[EpisodeResult, ...]]) -> Comparison:
        """Return the comparison of a measure in episodes from `play_alike`."""
        return cls(
            measure, [[measure.of(one) for one in game] for game in zip(*played, strict=True)]
        )

    @property
    def estimates(self) -> list[Estimate]:
        """The mean in each game."""
        return [estimate(values) for values in self.values]

    @property
    def difference(self) -> Estimate:
        """The mean lead of the first game over the second, paired by episode."""
        return estimate([a - b for a, b in zip(*self.values, strict=True)])

    @property
    def verdict(self) -> str:
        """``better`` or ``worse`` for the first game; empty if not significant."""
        found = self.difference
        if found.low is None or found.high is None or found.low <= 0.0 <= found.high:
            return ""
        return "better" if (found.low > 0.0) == (self.measure.better == MORE) else "worse"

    def to_json(self) -> dict[str, Any]:
        """Return all results as plain data."""
        data: dict[str, Any] = {"unit": self.measure.unit, "better": self.measure.better}
        for key, found, values in zip(SIDES, self.estimates, self.values, strict=False):
            plain = [value if math.isfinite(value) else None for value in values]
            data[key] = asdict(found) | {"episodes": plain}
        if len(self.values) > 1:
            data["difference"] = asdict(self.difference) | {"verdict": self.verdict}
        return data


def endings(played: Sequence[tuple[EpisodeResult, ...]]) -> list[dict[str, int]]:
    """Return the number of episodes with each outcome, by game."""
    return [
        dict(Counter(result.ended or "broken off" for result in game))
        for game in zip(*played, strict=True)
    ]
