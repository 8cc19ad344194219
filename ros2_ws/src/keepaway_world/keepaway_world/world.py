"""The keepaway world: bodies, referee, takers and the keepers' percepts, cycle by cycle."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from random import Random
from typing import Any

from hitab_core import world_seed
from hitab_world import (
    Action,
    Entity,
    EpisodeResult,
    EpisodicWorld,
    Placement,
    Sensed,
    WorldError,
    snapshots,
)
from hitab_world.simulating.snapshots import finite, text, texts
from keepaway_world.action import Order, orders_of
from keepaway_world.game.arranging import entities_of, placed, places_of
from keepaway_world.game.physics import Mover, Physics
from keepaway_world.game.players import takers_of
from keepaway_world.game.referee import drop_ball
from keepaway_world.game.rules import KEEPAWAY_RULES, Rules
from keepaway_world.parameters import PAPER, KeepawayParameters
from keepaway_world.percept import perceive

SNAPSHOT_VERSION = 2


class KeepawayWorld(EpisodicWorld):
    """A game on a field, keepaway by default; see `hitab_world.world.World` for the interface.

    `keepaway_world.percept` and `keepaway_world.action` define the layout of the keepers' percepts
    and actions. The takers are part of the world.

    Args:
        parameters: the game's parameters; the paper's by default.
        seed: the run's seed. Episode i draws from a generator seeded with it and i, so that any
            episode can be replayed by itself.
        rules: players, beginning and end of an episode.

    Raises:
        ParameterError: if no package offers the takers that the parameters name.
    """

    cycle_seconds = 0.1

    def __init__(
        self, parameters: KeepawayParameters = PAPER, seed: int = 0, rules: Rules = KEEPAWAY_RULES
    ) -> None:
        self.name, self.looks, self.measures = rules.name, rules.looks, rules.measures
        self.parameters = parameters
        self.size = (parameters.width, parameters.height)
        super().__init__(seed)
        self._random = Random()
        self._physics = Physics(parameters, self._random, rules.names)
        self._referee = rules.referee(self._physics)
        self._team = takers_of(self._physics, rules.takers)
        self._set_up, self._marks = rules.set_up, rules.marks
        self._movers = {mover.name: mover for mover in self._physics.movers}
        self._keepers = {mover.name: mover for mover in self._physics.keepers}
        self.agents: tuple[str, ...] = tuple(self._keepers)
        self._said: dict[str, str] = {}
        self._heard: dict[str, list[str]] = {}
        self.reset(0)

    def reset(self, episode: int | None = None, seed: int | None = None) -> None:
        """Begin the next episode of this run, or the given episode of the given run."""
        self.begin_episode(episode, seed)
        self._said.clear()
        self._heard.clear()
        self._random.seed(world_seed(self.seed, self.episode))
        self._referee.begin()
        self._team.begin()
        self._set_up(self._physics, self._random)

    @property
    def physics(self) -> Physics:
        """The bodies, for players in the same process that see everything."""
        return self._physics

    def percept(self, agent: str) -> Sensed:
        """Return a keeper's percept.

        Raises:
            WorldError: if there is no such keeper.
        """
        keeper = self._keepers.get(agent)
        if keeper is None:
            raise WorldError(f'no agent "{agent}" (known: {", ".join(self.agents)})')
        return perceive(self._physics, keeper), list(self._heard.get(agent, ()))

    def step(self, actions: Mapping[str, Action]) -> str | None:
        """Play one cycle; return why the episode ended with it, such as "out", else None."""
        self.refuse_after_end()
        takers = self._team.decide()  # from the state at the beginning of the cycle
        said, self.refused = self._perform(actions)
        for taker, order in zip(self._physics.takers, takers, strict=True):
            self._carry_out(taker, order)
        self._physics.advance()
        self._said = said
        self._heard = self._hear(said) if said else {}
        self.cycle += 1
        self.episode_cycle += 1
        happened = self._referee.judge(self._physics)
        if happened is not None:
            self.ended = happened
        elif self._referee.finds_stuck(self._physics.ball):
            drop_ball(self._physics)
        return happened

    def _perform(self, actions: Mapping[str, Action]) -> tuple[dict[str, str], dict[str, str]]:
        """Carry out the keepers' commands; return what they say and what was refused."""
        said: dict[str, str] = {}
        refused: dict[str, str] = {}
        orders = orders_of(actions, self.agents, self.parameters.say_length, refused)
        for name, order, say in orders:
            self._carry_out(self._keepers[name], order)
            if say:
                said[name] = say
        return said, refused

    def _carry_out(self, player: Mover, order: Order) -> None:
        kind, amount, direction = order
        if kind == "dash":
            self._physics.dash(player, amount)
        elif kind == "turn":
            self._physics.turn(player, amount)
        elif kind == "kick" and self._physics.kick(player, amount, direction):
            self._referee.saw_kick(player)
        elif kind == "catch":
            self._referee.saw_catch(player)

    def _hear(self, said: Mapping[str, str]) -> dict[str, list[str]]:
        """Return the messages that keepers hear: one message per cycle, chosen at random."""
        heard: dict[str, list[str]] = {}
        reach = self.parameters.say_range
        for name, keeper in self._keepers.items():
            messages = [
                message
                for speaker, message in said.items()
                if speaker != name and _distance(self._keepers[speaker], keeper) <= reach
            ]
            if len(messages) > 1:
                messages = [self._random.choice(messages)]
            if messages:
                heard[name] = messages
        return heard

    def entities(self) -> list[Entity]:
        """Return the true current state of the ball and the players, in SI units."""
        return [*entities_of(self._physics, self._said), *self._marks]

    def place(self, placements: Iterable[Placement], *, new_episode: bool = False) -> None:
        """Put players or the ball somewhere else; nothing is placed if anything is refused.

        Raises:
            WorldError: naming a thing that does not exist, or an impossible place or speed.
        """
        placements = list(placements)
        places = placed(placements, self._movers)
        if new_episode:
            self.reset()
            places = placed(placements, self._movers)
        for name, place in places.items():
            self._physics.put(self._movers[name], *place)

    def snapshot(self) -> dict[str, Any]:
        """Return the complete state, with its random generator, as JSON-serializable data."""
        version, internal, gauss = self._random.getstate()
        return {
            **snapshots.header(self, SNAPSHOT_VERSION),
            "movers": {name: list(place) for name, place in places_of(self._physics).items()},
            "said": dict(self._said),
            "heard": {name: list(messages) for name, messages in self._heard.items()},
            "referee": self._referee.state(),
            "random": [version, list(internal), gauss],
        }

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Restore a state that `snapshot` returned.

        Raises:
            WorldError: if the snapshot is damaged, or of a world of another kind or other
                parameters; nothing has changed then.
        """
        with snapshots.reading(snapshot, self, SNAPSHOT_VERSION) as moment:
            places = {m.name: _place(snapshot["movers"][m.name]) for m in self._physics.movers}
            said = {self._keepers[n].name: text(m) for n, m in snapshot["said"].items()}
            heard = {self._keepers[n].name: texts(m) for n, m in snapshot["heard"].items()}
            random = _random_state(*snapshot["random"])
            self._referee.restore(snapshot["referee"], self._physics.players)
        self._random.setstate(random)
        for name, place in places.items():
            self._physics.put(self._movers[name], *place)
        self._team.begin()
        moment.bring_back(self)
        self._said, self._heard = said, heard

    def result(self) -> EpisodeResult:
        """Return the result of the current episode so far; see `Referee.measures`."""
        return EpisodeResult.of(self, self._referee.measures(self.ended))


def _distance(a: Mover, b: Mover) -> float:
    return math.hypot(a.x - b.x, a.y - b.y)


def _place(figures: Iterable[Any]) -> tuple[float, float, float, float, float]:
    """Return a body's x, y, heading, vx, vy from a snapshot."""
    x, y, heading, vx, vy = map(finite, figures)
    return x, y, heading, vx, vy


def _random_state(version: Any, internal: Any, gauss: Any) -> tuple[Any, ...]:
    """Return the state of a random generator from a snapshot, after validating it."""
    state = version, tuple(internal), None if gauss is None else finite(gauss)
    Random().setstate(state)
    return state
