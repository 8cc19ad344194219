"""The interface of a simulated world; implement it to connect your own world.

A world is stepped by its caller and knows neither ROS nor clocks. An episode is identified by the
seed of the run and its number in the run: with the same two and the same actions, an episode is
the same bit for bit. All quantities of the interface are in SI units; x points right, y up, angles
are counter-clockwise (REP 103).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from hitab_core import HitabError, unknown

Action = tuple[Sequence[float], str]
"""The action of one agent: values in the domain's own layout, and a message or ""."""

Sensed = tuple[list[float], list[str]]
"""The percept of one agent: values in the domain's own layout, and the messages it hears."""

NAN = float("nan")


class WorldError(HitabError, ValueError):
    """A request that a world refuses as a whole; the message says what to do instead."""


@dataclass(frozen=True, slots=True)
class Entity:
    """The true state of something in a world: for viewers, never for agents.

    Attributes:
        name: unique in its world, such as ``keeper_1`` or ``ball``.
        kind: such as ``keeper``, ``taker``, ``ball``.
        x, y: center, m.
        heading: rad, counter-clockwise from x.
        vx, vy: velocity, m/s.
        radius: m.
        say: its message of the last cycle, "" if none.
    """

    name: str
    kind: str
    x: float
    y: float
    heading: float = 0.0
    vx: float = 0.0
    vy: float = 0.0
    radius: float = 0.0
    say: str = ""


SHAPES = ("disc", "square", "ball")


@dataclass(frozen=True, slots=True)
class Look:
    """The look of one kind of thing in viewers.

    Attributes:
        color: such as ``"#f2c94c"``; "" leaves it to the viewer, which colors agents by their
            active states.
        shape: ``"disc"``, ``"square"``, or ``"ball"``: a disc that stays visible from far away.
        faces: whether its heading shows.
        labelled: whether its name shows where there is room.
        opacity: from 0, invisible, to 1.
        layer: things on lower layers lie behind; agents are on layer 0.

    Raises:
        WorldError: if a value is none of these.
    """

    color: str = ""
    shape: str = "disc"
    faces: bool = True
    labelled: bool = True
    opacity: float = 1.0
    layer: int = 0

    def __post_init__(self) -> None:
        if self.color and not re.fullmatch("#[0-9a-fA-F]{6}", self.color):
            raise WorldError(f'a color is written like "#f2c94c", not "{self.color}"')
        if self.shape not in SHAPES:
            raise WorldError(unknown("shape", self.shape, SHAPES))
        if not 0.0 <= self.opacity <= 1.0:
            raise WorldError(f"an opacity is between 0 and 1, not {self.opacity}")
        if not -128 <= self.layer <= 127:
            raise WorldError(f"a layer is between -128 and 127, not {self.layer}")


@dataclass(frozen=True, slots=True)
class Placement:
    """The place to put an entity; NaN keeps the present value. Units as in `Entity`."""

    name: str
    x: float = NAN
    y: float = NAN
    heading: float = NAN
    vx: float = NAN
    vy: float = NAN


MORE, LESS = "more", "less"


@dataclass(frozen=True, slots=True)
class Measure:
    """A measure of an episode, by which behaviors are compared.

    A world may declare its own as ``measures``: names in `EpisodeResult.measures`, or ``seconds``.

    Attributes:
        name: the measure's name, such as ``boxes``.
        unit: the measure's unit, such as ``s``; "" for a number.
        better: `MORE` or `LESS`.

    Raises:
        WorldError: if ``better`` is neither.
    """

    name: str
    unit: str = ""
    better: str = MORE

    def __post_init__(self) -> None:
        if self.better not in (MORE, LESS):
            raise WorldError(unknown("way to be better", self.better, (MORE, LESS)))

    def of(self, result: EpisodeResult) -> float:
        """Return the measure's value in an episode; NaN if the episode has none."""
        return result.seconds if self.name == SECONDS else result.measures.get(self.name, NAN)


SECONDS = "seconds"
"""The measure that every episode has: its duration, s."""


@dataclass(frozen=True, slots=True)
class EpisodeResult:
    """The result of an episode.

    Attributes:
        number: number of the episode in its run, from 0.
        seed: seed of the run; ``reset(number, seed)`` plays the episode again.
        cycles: duration in cycles.
        seconds: duration in simulated seconds.
        ended: why the episode ended, such as ``"out"``; "" while it is being played.
        measures: further measures of this kind of world, such as ``{"passes": 3.0}``.
    """

    number: int
    seed: int
    cycles: int
    seconds: float
    ended: str
    measures: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, world: World, measures: Mapping[str, float]) -> EpisodeResult:
        """Return the result of a world's present episode so far, with the given measures."""
        # Rounded, so that 262 cycles of 0.1 s are not 26.200000000000003 s.
        seconds = round(world.episode_cycle * world.cycle_seconds, 9)
        return cls(world.episode, world.seed, world.episode_cycle, seconds, world.ended, measures)


class World(Protocol):
    """A simulation with agents in it, advanced cycle by cycle.

    Attributes:
        name: kind of world, which is also the name of its domain.
        agents: names of the agents, in a fixed order.
        cycle_seconds: simulated duration of a cycle, s.
        looks: how viewers draw each kind of entity; viewers choose for kinds without a look.
        size: width and height of the field, m; the field is centered on the origin.
        seed: seed of the run.
        episode: number of the present episode, from 0.
        cycle: cycles since the world was created; never goes back, except in `restore`.
        episode_cycle: cycles since the present episode began.
        ended: why the present episode has ended; "" while it is being played.
        refused: faults of the last cycle's actions, by agent; a refused action counts as no
            action.
    """

    name: str
    agents: tuple[str, ...]
    cycle_seconds: float
    looks: Mapping[str, Look]
    size: tuple[float, float]
    seed: int
    episode: int
    cycle: int
    episode_cycle: int
    ended: str
    refused: Mapping[str, str]

    def reset(self, episode: int | None = None, seed: int | None = None) -> None:
        """Begin the next episode of this run, or the given episode of the given run."""

    def percept(self, agent: str) -> Sensed:
        """Return the percept of ``agent``, the same at each call in a cycle."""

    def step(self, actions: Mapping[str, Action]) -> str | None:
        """Advance by one cycle; agents that are not in ``actions`` do nothing.

        Returns:
            Why the episode ended with this cycle, or None. After the end, the world stays
            unchanged until `reset` begins the next episode.

        Raises:
            WorldError: if the episode had already ended.
        """

    def entities(self) -> list[Entity]:
        """Return the true state of everything in the world."""

    def place(self, placements: Iterable[Placement], *, new_episode: bool = False) -> None:
        """Move things, optionally beginning the next episode with them there.

        Raises:
            WorldError: if any of them cannot be placed; nothing has changed then.
        """

    def snapshot(self) -> dict[str, Any]:
        """Return the complete state, random generator included, as JSON-able data."""

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Restore a state that `snapshot` returned.

        Raises:
            WorldError: if the snapshot is damaged or of another world; nothing has changed then.
                See `hitab_world.simulating.snapshots`.
        """

    def result(self) -> EpisodeResult:
        """Return the result of the present episode so far."""


LOOK = "look"
"""The agents' percepts have changed."""

RESTART = "restart"
"""An episode has begun."""


@runtime_checkable
class LiveWorld(Protocol):
    """Further members of a `World` that runs by itself, such as on another server.

    Attributes:
        waiting: why the world cannot be stepped now, such as a missing server, in one sentence
            with the remedy; "" if it can be stepped.
    """

    waiting: str

    def idle(self) -> str:
        """Keep the world alive while it is not stepped; must return quickly.

        The caller calls this at least ten times a second while the world is paused, has no agents,
        or is waiting.

        Returns:
            `RESTART` if an episode has begun, `LOOK` if the agents' percepts have changed, else
            "".
        """
