"""The keepaway world: bodies, referee, takers and the keepers' percepts, cycle by cycle."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from random import Random
from typing import Any

from hitab_core import has, world_seed
from hitab_world import (
    Action,
    Entity,
    EpisodeResult,
    Look,
    Placement,
    Sensed,
    WorldError,
    snapshots,
)
from hitab_world.snapshots import finite, text, texts
from keepaway_world import action, referee
from keepaway_world.parameters import PAPER, KeepawayParameters
from keepaway_world.percept import CYCLES_PER_SECOND, perceive
from keepaway_world.physics import Mover, Physics
from keepaway_world.players import takers_of

SNAPSHOT_VERSION = 2

FARTHEST = 1000.0
"""Largest distance from the center of the field, m, at which something can be placed."""


LOOKS: Mapping[str, Look] = {
    "keeper": Look(),
    "taker": Look("#c94f4f"),
    "ball": Look("#f2c94c", "ball", faces=False, labelled=False, layer=1),
}


class KeepawayWorld:
    """A game of keepaway; see `hitab_world.world.World` for the interface.

    `keepaway_world.percept` and `keepaway_world.action` define the layout of the keepers' percepts
    and actions. The takers are part of the world.

    Args:
        parameters: of the game; the paper's by default.
        seed: of the run. Episode i draws from a generator seeded by both, so that it can be
            replayed by itself.

    Raises:
        ParameterError: if there are no takers as the parameters name them.
    """

    name = "keepaway"
    cycle_seconds = 0.1
    looks = LOOKS

    def __init__(self, parameters: KeepawayParameters = PAPER, seed: int = 0) -> None:
        self.parameters = parameters
        self.size = (parameters.width, parameters.height)
        self.seed = seed
        self.episode = 0
        self.cycle = 0
        self.episode_cycle = 0
        self.ended = ""
        self.refused: Mapping[str, str] = {}
        self._random = Random()
        self._physics = Physics(parameters, self._random)
        self._referee = referee.Referee(parameters)
        self._team = takers_of(self._physics)
        self._movers = {mover.name: mover for mover in self._physics.movers}
        self._keepers = {mover.name: mover for mover in self._physics.keepers}
        self.agents: tuple[str, ...] = tuple(self._keepers)
        self._said: dict[str, str] = {}
        self._heard: dict[str, list[str]] = {}
        self.reset(0)

    def reset(self, episode: int | None = None, seed: int | None = None) -> None:
        """Begin the given episode, or the next one, of the given run, or of this one."""
        if seed is not None:
            self.seed = int(seed)
        self.episode = self.episode + 1 if episode is None else int(episode)
        self.episode_cycle = 0
        self.ended = ""
        self.refused = {}
        self._said.clear()
        self._heard.clear()
        self._random.seed(world_seed(self.seed, self.episode))
        self._referee.begin()
        self._team.begin()
        referee.set_up(self._physics, self._random)

    @property
    def physics(self) -> Physics:
        """The bodies, for players in the same process that see everything."""
        return self._physics

    def percept(self, agent: str) -> Sensed:
        """Return what a keeper perceives now.

        Raises:
            WorldError: if there is no such keeper.
        """
        keeper = self._keepers.get(agent)
        if keeper is None:
            raise WorldError(f'no keeper "{agent}" (known: {", ".join(self.agents)})')
        return perceive(self._physics, keeper), list(self._heard.get(agent, ()))

    def step(self, actions: Mapping[str, Action]) -> str | None:
        """Play one cycle; return "out" or "taken" if the episode ended with it, else None."""
        if self.ended:
            raise WorldError(
                f'episode {self.episode} has ended ("{self.ended}"); reset() begins the next one'
            )
        takers = self._team.decide()  # from the state at the beginning of the cycle
        said, self.refused = self._perform(actions)
        self._perform_takers(takers)
        self._physics.advance()
        self._said = said
        self._heard = self._hear(said) if said else {}
        self.cycle += 1
        self.episode_cycle += 1
        happened = self._referee.judge(self._physics)
        if happened is not None:
            self.ended = happened
        elif self._referee.finds_stuck(self._physics.ball):
            referee.drop_ball(self._physics)
        return happened

    def _perform(self, actions: Mapping[str, Action]) -> tuple[dict[str, str], dict[str, str]]:
        """Carry out the keepers' commands; return what they say and what was refused."""
        physics = self._physics
        said: dict[str, str] = {}
        refused: dict[str, str] = {}
        for name, keeper in self._keepers.items():
            if name not in actions:
                continue
            try:
                values, say = actions[name]
                kind, amount, direction = action.parse(values)
            except (ValueError, TypeError) as error:
                refused[name] = f"{name}: {error}; treated as no action"
                continue
            if kind == action.DASH:
                physics.dash(keeper, amount)
            elif kind == action.TURN:
                physics.turn(keeper, amount)
            elif kind == action.KICK and physics.kick(keeper, amount, direction):
                self._referee.saw_kick(keeper)
            if say:
                if not isinstance(say, str) or len(say) > self.parameters.say_length:
                    refused[name] = (
                        f"{name}: cannot say {say!r}: a message is text of at most "
                        f"{self.parameters.say_length} characters; it is not heard"
                    )
                else:
                    said[name] = say
        for name in actions:
            if name not in self._keepers:
                refused[name] = f'no keeper "{name}" (known: {", ".join(self.agents)})'
        return said, refused

    def _perform_takers(self, commands: Iterable[tuple[str, float, float]]) -> None:
        physics = self._physics
        for taker, (kind, amount, direction) in zip(physics.takers, commands, strict=True):
            if kind == "dash":
                physics.dash(taker, amount)
            elif kind == "turn":
                physics.turn(taker, amount)
            elif physics.kick(taker, amount, direction):
                self._referee.saw_kick(taker)

    def _hear(self, said: Mapping[str, str]) -> dict[str, list[str]]:
        """Return what each keeper hears: one message per cycle, chosen at random."""
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
        return [
            Entity(
                mover.name,
                mover.kind,
                mover.x,
                mover.y,
                mover.heading,
                mover.vx * CYCLES_PER_SECOND,
                mover.vy * CYCLES_PER_SECOND,
                mover.radius,
                self._said.get(mover.name, ""),
            )
            for mover in self._physics.movers
        ]

    def place(self, placements: Iterable[Placement], *, new_episode: bool = False) -> None:
        """Put players or the ball somewhere else; nothing is placed if anything is refused.

        Raises:
            WorldError: naming what does not exist or is impossible.
        """
        placements = list(placements)
        for placement in placements:
            mover = self._movers.get(placement.name)
            if mover is None:
                known = has(self._movers, placement.name)
                raise WorldError(f'nothing is called "{placement.name}" {known}')
            _check(placement, mover)
        if new_episode:
            self.reset()
        for placement in placements:
            mover = self._movers[placement.name]
            self._physics.put(
                mover,
                _or(placement.x, mover.x),
                _or(placement.y, mover.y),
                math.remainder(_or(placement.heading, mover.heading), 2.0 * math.pi),
                _or(placement.vx / CYCLES_PER_SECOND, mover.vx),
                _or(placement.vy / CYCLES_PER_SECOND, mover.vy),
            )

    def snapshot(self) -> dict[str, Any]:
        """Return the complete state, with its random generator, as JSON-serializable data."""
        version, internal, gauss = self._random.getstate()
        return {
            **snapshots.header(self, SNAPSHOT_VERSION),
            "movers": {m.name: [m.x, m.y, m.heading, m.vx, m.vy] for m in self._physics.movers},
            "said": dict(self._said),
            "heard": {name: list(messages) for name, messages in self._heard.items()},
            "referee": self._referee.state(),
            "random": [version, list(internal), gauss],
        }

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Restore a state that `snapshot` returned.

        Raises:
            WorldError: if it is of another kind of world, has other parameters, or is damaged;
                nothing has changed.
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
        """Return the result of the current episode so far; its measure is the number of passes."""
        return EpisodeResult.of(self, {"passes": float(self._referee.passes)})


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


def _or(value: float, otherwise: float) -> float:
    """Return ``value``, or ``otherwise`` if it is NaN."""
    return otherwise if math.isnan(value) else float(value)


def _check(placement: Placement, mover: Mover) -> None:
    """Refuse impossible placements: too far away, or faster than the body can move."""
    for field in ("x", "y", "heading", "vx", "vy"):
        if math.isinf(getattr(placement, field)):
            raise WorldError(f"{placement.name}: {field} is infinite; give a number or NaN")
    for field in ("x", "y"):
        if abs(getattr(placement, field)) > FARTHEST:
            raise WorldError(
                f"{placement.name}: {field} {getattr(placement, field):g} m is beyond "
                f"{FARTHEST:g} m; give it a place near the field, whose center is (0, 0)"
            )
    vx = _or(placement.vx, mover.vx * CYCLES_PER_SECOND)
    vy = _or(placement.vy, mover.vy * CYCLES_PER_SECOND)
    fastest = mover.speed_max * CYCLES_PER_SECOND
    if math.hypot(vx, vy) > fastest * 1.001 and not (
        math.isnan(placement.vx) and math.isnan(placement.vy)
    ):
        raise WorldError(
            f"{placement.name}: a speed of {math.hypot(vx, vy):.2f} m/s exceeds its maximum, "
            f"{fastest:g} m/s"
        )
