"""The foraging world: a field, its foragers and episodes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from foraging_world import action
from foraging_world.field import Field, Floats
from foraging_world.parameters import ForagingParameters
from foraging_world.perceiving import perceive_all
from hitab_core import has, world_seed
from hitab_world import (
    Action,
    Entity,
    EpisodeResult,
    EpisodicWorld,
    Look,
    Measure,
    Placement,
    Sensed,
    WorldError,
    snapshots,
)

SNAPSHOT_VERSION = 1
_STILL = Look(faces=False, layer=-1)
LOOKS: Mapping[str, Look] = {
    **dict.fromkeys(("forager", "scout", "carrier"), Look()),
    "small_box": replace(_STILL, color="#b98b4e", shape="square"),
    "large_box": replace(_STILL, color="#b98b4e", shape="square"),
    "obstacle": replace(_STILL, color="#8b939d", labelled=False),
    "home": replace(_STILL, color="#3f8f6b", opacity=0.28, layer=-2),
}
TIME, CLEARED = "time", "cleared"
MEASURES = (Measure("boxes"), Measure("small"), Measure("large"), Measure("pullers"))


class ForagingWorld(EpisodicWorld):
    """A swarm that forages; see `hitab_world.world.World` for its methods.

    `foraging_world.percept` describes the layout of percepts, `foraging_world.action` that of
    actions. Foragers do not hear each other.

    Args:
        parameters: parameters of the field, the boxes and the robots.
        seed: the run's seed. Episode i draws from a generator seeded with it and i, so that any
            episode can be replayed by itself.

    Raises:
        ParameterError: if the field has no room for all boxes and obstacles.
    """

    name = "foraging"
    cycle_seconds = 0.1
    looks = LOOKS
    measures = MEASURES

    def __init__(self, parameters: ForagingParameters | None = None, seed: int = 0) -> None:
        self.parameters = p = parameters or ForagingParameters()
        self.size = (p.width, p.height)
        super().__init__(seed)
        self._field = Field(p)
        self.agents = tuple(_names(p, self._field))
        self._index = {name: i for i, name in enumerate(self.agents)}
        self._boxes = [
            *(f"small_box_{i + 1}" for i in range(p.small_boxes)),
            *(f"large_box_{i + 1}" for i in range(p.large_boxes)),
        ]
        self._perceived: Floats | None = None
        self._rows: list[list[float]] = []
        self.reset(0)

    def reset(self, episode: int | None = None, seed: int | None = None) -> None:
        """Begin the next episode of this run, or the given episode of the given run."""
        self.begin_episode(episode, seed)
        self._field.begin(world_seed(self.seed, self.episode))
        self._perceived = None

    # -- perceiving -------------------------------------------------------------------------

    def percepts(self) -> Floats:
        """Return the percepts of all foragers: a row each, in the order of ``agents``.

        The array is computed once a cycle and must not be changed.
        """
        if self._perceived is None:
            self._perceived = perceive_all(self._field)
            self._rows = self._perceived.tolist()
        return self._perceived

    def percept(self, agent: str) -> Sensed:
        """Return a forager's percept.

        Raises:
            WorldError: if there is no such forager.
        """
        index = self._index.get(agent)
        if index is None:
            raise WorldError(
                f'no robot "{agent}" (has {len(self.agents)}: '
                f"{self.agents[0]} to {self.agents[-1]})"
            )
        self.percepts()
        return self._rows[index], []

    # -- acting -----------------------------------------------------------------------------

    def step(self, actions: Mapping[str, Action]) -> str | None:
        """Play one cycle; return "time" or "cleared" if the episode ended with it, else None."""
        self.refuse_after_end()
        commands, self.refused = action.parse_all(actions, self._index)
        self._field.step(commands, self.cycle_seconds)
        self._perceived = None
        self.cycle += 1
        self.episode_cycle += 1
        if self._boxes and not self._field.present.any() and not self.parameters.renew:
            self.ended = CLEARED
        elif self.episode_cycle * self.cycle_seconds >= self.parameters.duration - 1e-9:
            self.ended = TIME
        return self.ended or None

    # -- showing and arranging --------------------------------------------------------------

    def entities(self) -> list[Entity]:
        """Return the true state of home, obstacles, boxes and foragers."""
        p, field = self.parameters, self._field
        found = [Entity("home", "home", 0.0, 0.0, radius=p.home_radius)]
        found += [
            Entity(f"obstacle_{i + 1}", "obstacle", x, y, radius=p.obstacle_radius)
            for i, (x, y) in enumerate(field.obstacles.tolist())
        ]
        boxes = np.column_stack([field.box_xy, field.box_velocity, field.box_radius]).tolist()
        found += [
            Entity(name, name.rpartition("_")[0], x, y, 0.0, vx, vy, radius)
            for name, present, (x, y, vx, vy, radius) in zip(
                self._boxes, field.present, boxes, strict=True
            )
            if present
        ]
        robots = np.column_stack([field.xy, field.heading, field.velocity]).tolist()
        found += [
            Entity(name, name.rpartition("_")[0], x, y, heading, vx, vy, p.forager_radius)
            for name, (x, y, heading, vx, vy) in zip(self.agents, robots, strict=True)
        ]
        return found

    def place(self, placements: Iterable[Placement], *, new_episode: bool = False) -> None:
        """Move foragers or boxes; nothing is placed if anything is refused.

        A forager that is moved lets go of its box; all foragers let go of a box that is moved.
        Velocities cannot be set: they follow from the next command.

        Raises:
            WorldError: naming the unknown thing or the invalid value.
        """
        placements = list(placements)
        for placement in placements:
            self._check(placement)
        if new_episode:
            self.reset()
        field = self._field
        for placement in placements:
            forager = self._index.get(placement.name)
            if forager is not None:
                _put(field.xy[forager], placement)
                if not math.isnan(placement.heading):
                    field.heading[forager] = math.remainder(placement.heading, 2.0 * math.pi)
                field.velocity[forager] = 0.0
                field.let_go(np.arange(len(self.agents)) == forager)
            else:
                box = self._boxes.index(placement.name)
                field.let_go(field.held == box)
                _put(field.box_xy[box], placement)
                field.box_velocity[box] = 0.0
        self._perceived = None

    def _check(self, placement: Placement) -> None:
        name, there = placement.name, [*self.agents, *self._boxes]
        if name == "home" or name.startswith("obstacle_"):
            raise WorldError(f"{name} cannot be moved; move foragers or boxes")
        if name not in there:
            raise WorldError(f'nothing is called "{name}" {has(there, name)}')
        if any(map(math.isinf, (placement.x, placement.y, placement.heading))):
            raise WorldError(f"{name}: a value is infinite; give a number or NaN")
        for figure, half in (("x", self.size[0] / 2.0), ("y", self.size[1] / 2.0)):
            if abs(getattr(placement, figure)) > half:
                raise WorldError(
                    f"{name}: {figure} is {getattr(placement, figure):g} m, outside the field; "
                    f"give {-half:g} to {half:g} m"
                )
        if not all(math.isnan(v) or v == 0.0 for v in (placement.vx, placement.vy)):
            raise WorldError(
                f"{name}: the velocity cannot be set, it follows from commands and pulling; "
                "leave it out"
            )
        if name in self._boxes and not self._field.present[self._boxes.index(name)]:
            raise WorldError(f"{name} is home already; a new episode brings it back")

    # -- snapshots --------------------------------------------------------------------------

    def snapshot(self) -> dict[str, Any]:
        """Return the complete state, random generator included, as JSON-able data."""
        return {**snapshots.header(self, SNAPSHOT_VERSION), "field": self._field.state()}

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Restore a state that `snapshot` returned.

        Raises:
            WorldError: if the snapshot is damaged, or of a world of another kind or other
                parameters; nothing has changed then.
        """
        with snapshots.reading(snapshot, self, SNAPSHOT_VERSION) as moment:
            self._field.restore(snapshot["field"])
        moment.bring_back(self)
        self._perceived = None

    def result(self) -> EpisodeResult:
        """Return the result of the present episode so far.

        Its measures are the boxes brought home, also by size, and the mean number of foragers that
        hold a box.
        """
        small, large = map(float, self._field.collected.tolist())
        pullers = self._field.holding.item() / max(self.episode_cycle, 1)
        measures = {"boxes": small + large, "small": small, "large": large, "pullers": pullers}
        return EpisodeResult.of(self, measures)


def _names(p: ForagingParameters, field: Field) -> Iterator[str]:
    """Yield the names of the robots: each one's kind, and its number within the kind."""
    counts = Counter[str]()
    for scout in field.scouts.tolist():
        kind = ("scout" if scout else "carrier") if p.scouts else "forager"
        counts[kind] += 1
        yield f"{kind}_{counts[kind]}"


def _put(xy: Floats, placement: Placement) -> None:
    """Set the coordinates that are given."""
    for axis, value in enumerate((placement.x, placement.y)):
        if not math.isnan(value):
            xy[axis] = value
