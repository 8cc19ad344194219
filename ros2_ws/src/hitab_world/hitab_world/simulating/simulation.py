"""A world in one file: a class that steps, and functions as behaviors, features and targets.

The functions are marked with decorators of `hitab_core.notebook.plain`; `hitab up FILE` runs the
file.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from traceback import extract_tb
from types import MappingProxyType
from typing import Any, ClassVar

from hitab_core import HitabError, has, load_file, some, world_seed
from hitab_world import snapshots
from hitab_world.parameters import NOT_NEGATIVE, Limit, Parameters
from hitab_world.simulating.episodic_world import EpisodicWorld
from hitab_world.world import (
    Action,
    Entity,
    EpisodeResult,
    Look,
    Measure,
    Placement,
    Sensed,
    WorldError,
)

SIMULATION_VERSION = 2
PLACED = "placed"
"""Key of a placement in the record of an episode; steps have agents' actions instead."""

ENDED_BY_TIME = "time"
Values = Sequence[float]
Things = Mapping[str, Mapping[str, float]]


class Simulation:
    """Base class of a world in one file.

    Attributes:
        agents: number of agents; they are called agent_1, agent_2 and so on.
        cycle_seconds: simulated duration of a step, s.
        size: width and height of the field, m; the field is centered on the origin.
        looks: how viewers draw each kind of thing.
        measures: the measures by which behaviors are compared.
        longest: maximum number of steps in an episode, which then ends with "time".
        ended: why the episode has ended, set by a step; `reset` begins with "".
        names: names of the agents.
    """

    agents: int = 1
    cycle_seconds: float = 0.1
    size: tuple[float, float] = (10.0, 10.0)
    looks: Mapping[str, Look] = MappingProxyType({})
    measures: Sequence[Measure] = ()
    longest: int = 10_000
    ended: str = ""
    names: tuple[str, ...] = ()

    def reset(self, seed: int) -> Mapping[str, Values]:
        """Begin an episode, which depends on the seed alone; return each agent's percept.

        By default, the episode begins with a step in which no agent acts.
        """
        return self.step({name: [] for name in self.names})

    def step(self, actions: Mapping[str, Values]) -> Mapping[str, Values]:
        """Advance by one step; return each agent's percept.

        The action of an agent that does nothing is empty.
        """
        raise NotImplementedError("define step(self, actions)")

    def place(self, things: Things) -> Mapping[str, Values]:
        """Put things elsewhere; return each agent's percept.

        Args:
            things: the given values of each thing, by its name: x and y in m, heading in rad, vx
                and vy in m/s.
        """
        raise WorldError(
            f"{some(list(things))} cannot be moved; define place(self, things) in the file, or "
            "begin another episode"
        )

    def draw(self) -> Iterable[Entity]:
        """Return the things that viewers show."""
        return ()

    def measured(self) -> Mapping[str, float]:
        """Return the measures of the episode so far."""
        return {}


def simulation_in(path: Path) -> type[Simulation]:
    """Return the simulation in a file.

    Raises:
        VocabularyError: if the file cannot be run.
        WorldError: if it has none, or more than one.
    """
    if path.is_file() and b"hitab" not in path.read_bytes():
        raise WorldError(
            f"{path}: imports nothing of HiTAB; a world is a class derived from "
            "hitab_world.Simulation. The file was not run"
        )
    file = load_file(path)
    found = [
        thing
        for thing in vars(file).values()
        if isinstance(thing, type)
        and issubclass(thing, Simulation)
        and thing.__module__ == file.__name__
    ]
    if len(found) != 1:
        what = some([kind.__name__ for kind in found]) if found else "no class"
        raise WorldError(f"{path}: has {what} derived from Simulation; it must have exactly one")
    kind = found[0]
    if isinstance(kind.agents, bool) or not isinstance(kind.agents, int) or kind.agents < 1:
        raise WorldError(
            f"{path}: {kind.__name__}.agents is {kind.agents!r}; it must be a whole number from 1"
        )
    return kind


@dataclass(frozen=True)
class SimulationParameters(Parameters):
    """The file of a simulation, and how many agents; 0 for the number in the file."""

    WORLD: ClassVar[str] = "simulation"
    LIMITS: ClassVar[Mapping[str, Limit]] = {"agents": NOT_NEGATIVE}

    file: str = ""
    agents: int = 0


class SimulationWorld(EpisodicWorld):
    """Adapts a simulation to the interface `hitab_world.world.World`.

    A snapshot holds the actions and placements of the episode so far; restoring repeats them.
    """

    def __init__(self, parameters: SimulationParameters, seed: int = 0) -> None:
        kind = simulation_in(Path(parameters.file))
        self._place = f"{parameters.file}: {kind.__name__}"
        self.parameters = parameters
        self.agents = tuple(f"agent_{i + 1}" for i in range(parameters.agents or kind.agents))
        self._kind = kind
        self._source = hashlib.sha256(Path(parameters.file).read_bytes()).hexdigest()[:16]
        self.name = Path(parameters.file).stem
        self.cycle_seconds = kind.cycle_seconds
        self.size = kind.size
        self.looks = kind.looks
        self.measures = kind.measures
        super().__init__(seed)
        self._begin()

    def _begin(self) -> None:
        self._simulation, self._percepts, self._done = self._played([], self.seed, self.episode)

    def _played(
        self, done: list[dict[str, Any]], seed: int, episode: int
    ) -> tuple[Simulation, dict[str, list[float]], list[dict[str, Any]]]:
        """Return a simulation after these steps and placements of an episode.

        Raises:
            WorldError: naming the line of the file that raised.
        """
        with self._naming_the_line():
            simulation = self._kind()
            simulation.agents, simulation.names = len(self.agents), self.agents
            percepts = self._checked(simulation.reset(world_seed(seed, episode)), "reset")
            for one in done:
                percepts = self._done_once(simulation, one)
        return simulation, percepts, list(done)

    def _done_once(self, simulation: Simulation, one: dict[str, Any]) -> dict[str, list[float]]:
        """Return the percepts of all agents after a step or a placement."""
        if PLACED not in one:
            return self._stepped(simulation, one)
        things = {name: dict(fields) for name, fields in one[PLACED].items()}
        return self._checked(simulation.place(things), "place")

    def _do(self, one: dict[str, Any]) -> None:
        """Do a step or a placement; if it fails, perhaps half-way, the world does not change."""
        try:
            with self._naming_the_line():
                self._percepts = self._done_once(self._simulation, one)
        except WorldError:
            again = self._played(self._done, self.seed, self.episode)
            self._simulation, self._percepts, self._done = again
            raise
        self._done.append(one)

    @contextmanager
    def _naming_the_line(self) -> Iterator[None]:
        """Turn exceptions of the file into `WorldError`, naming the line."""
        try:
            yield
        except HitabError:
            raise
        except Exception as error:
            file = str(Path(self.parameters.file).resolve())
            lines = [f.lineno for f in extract_tb(error.__traceback__) if f.filename == file]
            place = f"{file}:{lines[-1]}" if lines else self._place
            raise WorldError(
                f"{place}: {type(error).__name__}: {error}; correct the file"
            ) from error

    def _stepped(
        self, simulation: Simulation, actions: Mapping[str, list[float]]
    ) -> dict[str, list[float]]:
        """Return the percepts of all agents after a step; the step may change its arguments."""
        given = {name: list(values) for name, values in actions.items()}
        percepts = self._checked(simulation.step(given), "step")
        if not isinstance(simulation.ended, str):
            raise WorldError(
                f"{self._place}.step() set ended to {simulation.ended!r}; set it to a text that "
                'says why, such as "goal", or leave it ""'
            )
        return percepts

    def _checked(self, percepts: Any, method: str) -> dict[str, list[float]]:
        """Return the checked percepts of all agents.

        Raises:
            WorldError: naming the agent whose percept is missing or wrong.
        """
        where = f"{self._place}.{method}()"
        if not isinstance(percepts, Mapping):
            raise WorldError(f"{where} returned {percepts!r}; return each agent's percept by name")
        for name in percepts:
            if name not in self.agents:
                raise WorldError(f'{where}: no agent "{name}" {has(self.agents, name)}')
        found = {}
        for name in self.agents:
            try:
                found[name] = [float(value) for value in percepts[name]]
            except (LookupError, TypeError, ValueError) as error:
                raise WorldError(
                    f"{where}: {name} has no list of numbers ({type(error).__name__}: {error}); "
                    "return one for each agent"
                ) from error
            if not all(map(math.isfinite, found[name])):
                raise WorldError(
                    f"{where}: the percept of {name} is not finite: {found[name]}; a feature may "
                    "return NaN, but percepts must be finite"
                )
        if len({*map(len, found.values())}) > 1:
            raise WorldError(f"{where}: percepts differ in length; give all agents equally many")
        return found

    def reset(self, episode: int | None = None, seed: int | None = None) -> None:
        """Begin the next episode of this run, or the given episode of the given run."""
        self.begin_episode(episode, seed)
        self._begin()

    def percept(self, agent: str) -> Sensed:
        """Return an agent's percept."""
        if agent not in self._percepts:
            raise WorldError(f'no agent "{agent}" {has(self.agents, agent)}')
        return list(self._percepts[agent]), []

    def step(self, actions: Mapping[str, Action]) -> str | None:
        """Play one cycle; return why the episode ended with it, or None.

        Raises:
            WorldError: naming the line of the file that raised; then nothing has changed.
        """
        self.refuse_after_end()
        done: dict[str, list[float]] = {name: [] for name in self.agents}
        refused = {}
        for name, action in actions.items():
            try:
                if name not in done:
                    raise ValueError(f"there is no such agent {has(self.agents, name)}")
                values = [float(value) for value in action[0]]
                if not all(map(math.isfinite, values)):
                    raise ValueError("needs finite values")
                done[name] = values
            except (LookupError, TypeError, ValueError) as error:
                refused[name] = f"{name}: {error}; treated as no action"
        self._do(done)
        self.refused = refused
        self.cycle += 1
        self.episode_cycle += 1
        self.ended = self._simulation.ended
        if not self.ended and self.episode_cycle >= self._kind.longest:
            self.ended = self._simulation.ended = ENDED_BY_TIME
        return self.ended or None

    def entities(self) -> list[Entity]:
        """Return the drawn things of the simulation."""
        with self._naming_the_line():
            return list(self._simulation.draw())

    def place(self, placements: Iterable[Placement], *, new_episode: bool = False) -> None:
        """Put things elsewhere, in a new episode if wanted; if one is refused, nothing changes.

        Raises:
            WorldError: if a number is infinite, or the file refuses.
        """
        things: dict[str, dict[str, float]] = {}
        for one in placements:
            given = {key: getattr(one, key) for key in ("x", "y", "heading", "vx", "vy")}
            things[one.name] = {key: v for key, v in given.items() if not math.isnan(v)}
            if not all(map(math.isfinite, things[one.name].values())):
                raise WorldError(f"{one.name} cannot be placed at {things[one.name]}")
        before = self.snapshot() if new_episode else {}
        if new_episode:
            self.reset()
        try:
            if things:
                self._do({PLACED: things})
        except WorldError:
            if before:
                self.restore(before)
            raise

    def snapshot(self) -> dict[str, Any]:
        """Return the actions of the episode, as JSON-able data."""
        done = [dict(one) for one in self._done]
        return {**snapshots.header(self, SIMULATION_VERSION), "source": self._source, "done": done}

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Repeat the steps and placements of a snapshot.

        Raises:
            WorldError: if the snapshot is of another world, or damaged; nothing has changed then.
        """
        with snapshots.reading(snapshot, self, SIMULATION_VERSION) as moment:
            if snapshots.text(snapshot["source"]) != self._source:
                raise WorldError(
                    f"{self.parameters.file} is not as it was when the snapshot was taken; "
                    "restore that version of the file, or take another snapshot"
                )
            done = [
                {PLACED: {n: _finite(f) for n, f in one[PLACED].items()}}
                if PLACED in one
                else {name: [snapshots.finite(v) for v in one[name]] for name in self.agents}
                for one in snapshot["done"]
            ]
            steps = sum(PLACED not in one for one in done)
            if steps != moment.episode_cycle:
                raise ValueError(f"{steps} steps in {moment.episode_cycle} cycles")
            again = self._played(done, moment.seed, moment.episode)
            if steps >= self._kind.longest and not again[0].ended:
                again[0].ended = ENDED_BY_TIME
            if again[0].ended != moment.ended:
                raise ValueError("the episode does not end as it did")
        moment.bring_back(self)
        self._simulation, self._percepts, self._done = again

    def result(self) -> EpisodeResult:
        """Return the result of the present episode so far."""
        with self._naming_the_line():
            return EpisodeResult.of(self, dict(self._simulation.measured()))


def _finite(fields: Mapping[str, Any]) -> dict[str, float]:
    return {name: snapshots.finite(value) for name, value in fields.items()}
