"""Episodes in one process: world and agents without ROS, as fast as the machine allows.

Each agent has a player, which is notified when an episode begins and makes the agent's
body act on each percept. `AutomatonPlayer` performs a behavior of a repertoire just as an agent
node does; `PolicyPlayer` calls a function with the body. Agents perceive and act through the
domain's body alone, so the same behaviors play the same game over topics.

Example::

    world = KeepawayWorld(seed=7)
    repertoire = Repertoire(DOMAIN, library)
    results = play(world, perform(world, repertoire, "Keepaway"), episodes=200)

A world that computes all percepts at once does so at the first `World.percept` of a cycle.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from random import Random
from typing import Any, Protocol

from hitab_core import Repertoire, Term, agent_seed
from hitab_core.running import FeatureCache, RunContext, performance
from hitab_world.world import EpisodeResult, World

Policy = Callable[[Any], None]
"""A function that makes a body act; called once a cycle, after the body has sensed."""


Between = Callable[[], None]


class Player(Protocol):
    """A player of one agent.

    Attributes:
        body: the agent's body; see `hitab_core.domain.Body`.
    """

    body: Any

    def begin(self, seed: int, episode: int) -> None:
        """Begin an episode; its random draws depend only on the seed and the episode."""

    def tick(self) -> None:
        """Act on the percept that the body has just sensed."""


class PolicyPlayer:
    """Plays an agent by a function of its body."""

    def __init__(self, body: Any, policy: Policy) -> None:
        self.body = body
        self._policy = policy

    def begin(self, seed: int, episode: int) -> None:
        """Do nothing: a policy has no state."""

    def tick(self) -> None:
        """Act on the percept that the body has just sensed."""
        self._policy(self.body)


class AutomatonPlayer:
    """Plays an agent by performing a behavior, from Start in each episode.

    Args:
        repertoire: the available behaviors.
        term: the behavior to perform, bound to targets.
        name: name of the agent.
        time: returns the simulated time, s, for timers.
    """

    def __init__(
        self, repertoire: Repertoire, term: Term, name: str, *, time: Callable[[], float] = float
    ) -> None:
        self.body = repertoire.domain.body(name)
        self._name = name
        self._random = Random()
        self._feature_cache = FeatureCache(self.body, repertoire.domain)
        context = RunContext(repertoire, self.body, self._feature_cache, self._random.random)
        self.running = performance(context, term)
        self._clock = context.clock
        self._time = time

    def begin(self, seed: int, episode: int) -> None:
        """Begin an episode, at Start, with the agent's generator seeded for it."""
        self._random.seed(agent_seed(seed, episode, self._name))
        self._clock.now = self._time()
        self.running.stop()
        self.running.start()

    def tick(self) -> None:
        """Perform one timestep on the percept that the body has just sensed."""
        self._clock.now = self._time()
        self._feature_cache.forget()
        self.running.tick()


def perform(world: World, repertoire: Repertoire, behavior: str | Term) -> dict[str, Player]:
    """Return players that perform the same behavior with all agents of a world."""
    term = Term.parse(behavior) if isinstance(behavior, str) else behavior

    def time() -> float:
        return world.episode_cycle * world.cycle_seconds

    return {name: AutomatonPlayer(repertoire, term, name, time=time) for name in world.agents}


def play(
    world: World,
    players: Mapping[str, Player],
    episodes: int = 1,
    *,
    between: Between | None = None,
    cycles_max: int | None = None,
    first: int | None = None,
) -> list[EpisodeResult]:
    """Play whole episodes and return their results; the world stays at the end of the last.

    Args:
        world: the world, which is reset before each episode.
        players: the players by agent; agents without a player do nothing.
        episodes: number of episodes.
        between: see `cycle`.
        cycles_max: maximum cycles of an episode; if it is cut off, its result has ``ended == ""``.
        first: number of the first episode; by default the next one, or the present one if no cycle
            of it has been played yet.
    """
    fresh = world.episode_cycle == 0 and not world.ended
    number = first if first is not None else world.episode + (0 if fresh else 1)
    results = []
    for episode in range(number, number + episodes):
        world.reset(episode)
        results.append(play_on(world, players, between=between, cycles_max=cycles_max))
    return results


def play_on(
    world: World,
    players: Mapping[str, Player],
    *,
    between: Between | None = None,
    cycles_max: int | None = None,
) -> EpisodeResult:
    """Play the present episode from where the world is, all agents at Start, to its end."""
    for player in players.values():
        player.begin(world.seed, world.episode)
    while not world.ended and (cycles_max is None or world.episode_cycle < cycles_max):
        cycle(world, players, between)
    return world.result()


def cycle(
    world: World, players: Mapping[str, Player], between: Between | None = None
) -> str | None:
    """Play one cycle: all perceive, all act; return why the episode ended, or None.

    Args:
        world: the world to step.
        players: the players by agent.
        between: called between the percepts and the actions of a cycle, such as for commanders.
    """
    for name, player in players.items():
        player.body.sense(*world.percept(name))
    if between is not None:
        between()
    actions = {}
    for name, player in players.items():
        player.tick()
        actions[name] = player.body.act()
    return world.step(actions)
