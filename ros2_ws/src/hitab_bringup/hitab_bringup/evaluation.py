"""Evaluation of a swarm: episodes that its cast plays without ROS, and how two casts compare.

The world and what its agents perform are made in this process.
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
from hitab_world.ros_parameters import GivenParameters

SIDES = ("evaluated", "against")
"""The names of two casts that are compared."""


class GameSetup(NamedTuple):
    """A world in this process, and what plays its agents.

    Attributes:
        between: called between the percepts and the actions of a cycle, such as for commanders.
    """

    world: World
    players: Mapping[str, Player]
    between: Between | None = None


def evaluated_swarm(swarm: str, seed: int, parameters: Sequence[str]) -> SwarmDescription:
    """Return a swarm as episodes of it are played without ROS.

    Args:
        swarm: a swarm description, or the name of a shipped one.
        seed: of the run.
        parameters: of its world, as ``NAME=VALUE``, instead of the swarm's own.

    Raises:
        HitabError: if it has no world, or a parameter is not given like that.
    """
    described = described_swarm(swarm, None)
    world = described.with_world().world  # raises if there is none
    assert world is not None
    return described.with_world(
        seed=seed, parameters={**world.parameters, **figures_in(parameters)}
    )


def figures_in(texts: Sequence[str]) -> dict[str, Any]:
    """Return the figures of a world that options give as ``NAME=VALUE``, as YAML reads them.

    Raises:
        HitabError: if one is not given like that.
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
    """Yield the world that a description describes.

    Raises:
        HitabError: if one of its figures is invalid.
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
    """Return the players of a world's agents; other agents than the world has are left out.

    Raises:
        DescriptionError: if it has none of them.
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
    """Yield a game for each way to cast the agents of a swarm; all worlds begin alike.

    Raises:
        HitabError: if there is no such game.
    """
    described = swarm.with_world().world  # raises if there is none
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
    """Return a game in which those commanders give orders that perform something."""
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
            continue  # an agent, or the commander of some that this world does not have
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
    """Return a library with what a part can perform, a copy if that is not what its own has."""
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
    """Return a world's declared measures, or else those of its results, as if more is better."""
    names = {name for result in results for name in result.measures}
    undeclared = (Measure(SECONDS, "s"), *map(Measure, sorted(names)))
    return getattr(world, "measures", ()) or undeclared


def play_alike(
    games: Sequence[GameSetup], episodes: int, *, longest: float = 0.0
) -> Iterator[tuple[EpisodeResult, ...]]:
    """Play the same episodes in each game; yield the results of each episode, in order of games.

    Args:
        games: with worlds of the same seed and figures.
        episodes: how many.
        longest: break an episode off after so many simulated seconds; 0 for never.
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
        values: of the episodes, by game.
    """

    measure: Measure
    values: Sequence[Sequence[float]]

    @classmethod
    def of(cls, measure: Measure, played: Sequence[tuple[EpisodeResult, ...]]) -> Comparison:
        """Return how a measure was in episodes that `play_alike` yielded."""
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
        """Whether the first game is ``better`` or ``worse``; "" if that is not certain."""
        found = self.difference
        if found.low is None or found.high is None or found.low <= 0.0 <= found.high:
            return ""
        return "better" if (found.low > 0.0) == (self.measure.better == MORE) else "worse"

    def to_json(self) -> dict[str, Any]:
        """Return all figures as plain data."""
        data: dict[str, Any] = {"unit": self.measure.unit, "better": self.measure.better}
        for key, found, values in zip(SIDES, self.estimates, self.values, strict=False):
            plain = [value if math.isfinite(value) else None for value in values]
            data[key] = asdict(found) | {"episodes": plain}
        if len(self.values) > 1:
            data["difference"] = asdict(self.difference) | {"verdict": self.verdict}
        return data


def endings(played: Sequence[tuple[EpisodeResult, ...]]) -> list[dict[str, int]]:
    """Return how often episodes ended in which way, by game."""
    return [
        dict(Counter(result.ended or "broken off" for result in game))
        for game in zip(*played, strict=True)
    ]
