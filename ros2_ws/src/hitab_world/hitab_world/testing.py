"""Checks for any `hitab_world.world.World`, including your own.

In a test::

    from hitab_world.testing import Wandering, check_world

    def test_it_is_a_world():
        check_world(lambda seed: MyWorld(seed=seed), Wandering([[1.0, 0.0], [0.0, 0.5]]))

`check_world` raises an AssertionError that names the broken requirement of the interface. The idea
is that of PettingZoo's ``api_test`` and ``seed_test``.
"""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from random import Random
from typing import Any

from hitab_world.world import (
    Action,
    Entity,
    EpisodeResult,
    Look,
    Measure,
    Placement,
    World,
    WorldError,
)

MakeWorld = Callable[[int], World]
"""Creates a world, given the seed of the run."""

NO_AGENT_NAME = "nobody_is_called_so"
LIKE_EACH_OTHER = 3
"""How many values of a list in a snapshot are damaged; a random generator has hundreds."""


class Wandering:
    """Varied actions for all agents; asking again in the same cycle gives the same actions.

    Args:
        samples: actions that agents can do, in the domain's own layout.
        say: possible messages.
    """

    def __init__(self, samples: Sequence[Sequence[float]], say: Sequence[str] = ()) -> None:
        self._samples = [list(sample) for sample in samples]
        self._say = ["", *say]

    def actions(self, world: World) -> dict[str, Action]:
        """Return the agents' actions of this cycle; about one in ten does nothing."""
        random = Random(world.cycle)
        return {
            name: (random.choice(self._samples), random.choice(self._say))
            for name in world.agents
            if random.random() > 0.1
        }


def check_world(make: MakeWorld, wandering: Wandering, cycles: int = 60) -> None:
    """Run all checks on a world."""
    _check_interface(make(1))
    _check_cycles(make(1), wandering, cycles)
    _check_seeds(make, wandering, cycles)
    _check_snapshots(make, wandering, cycles)
    _check_damaged_snapshots(make(1), wandering, cycles)
    _check_bad_actions(make, wandering)
    _check_bad_placements(make(1))


def _observed(world: World) -> tuple[Any, ...]:
    """Return everything that can be seen of a world now."""
    sensed = [world.percept(name) for name in world.agents]
    return sensed, world.entities(), world.result(), world.ended


def _wander(world: World, wandering: Wandering, cycles: int) -> list[Any]:
    """Let the agents do varied things for some cycles; return everything that could be seen."""
    seen = [_observed(world)]
    for _ in range(cycles):
        _step(world, wandering)
        seen.append(_observed(world))
    return seen


def _step(world: World, wandering: Wandering) -> None:
    if world.ended:
        world.reset()
    world.step(wandering.actions(world))


def _check_interface(world: World) -> None:
    """Check that a new world has the attributes of the interface, with valid values."""
    assert isinstance(world.name, str), "name must be text"
    assert world.name, "name must not be empty"
    assert world.agents, "a world has agents"
    assert len(set(world.agents)) == len(world.agents), "names of agents must differ"
    assert world.cycle_seconds > 0.0, "cycle_seconds must be positive"
    assert len(world.size) == 2, "size is width and height"
    assert min(world.size) > 0.0, "size must be positive"
    new = (world.episode, world.cycle, world.episode_cycle, world.ended)
    assert new == (0, 0, 0, ""), "a new world is at the beginning of episode 0"
    assert isinstance(world.result(), EpisodeResult), "result() is an EpisodeResult"
    for measure in getattr(world, "measures", ()):
        assert isinstance(measure, Measure), "measures are Measure objects"
        assert not math.isnan(measure.of(world.result())), f"result() has no {measure.name}"
    for name in world.agents:
        values, heard = world.percept(name)
        assert all(isinstance(v, float) for v in values), f"percept of {name}: values are floats"
        assert all(isinstance(h, str) for h in heard), f"percept of {name}: messages are text"
    entities = world.entities()
    assert all(isinstance(e, Entity) for e in entities), "entities() are Entity objects"
    names = {e.name for e in entities}
    assert len(names) == len(entities), "names of entities must differ"
    assert set(world.agents) <= names, "every agent is an entity, to be visible"
    assert all(isinstance(look, Look) for look in world.looks.values()), "looks are Look objects"
    _refuses(lambda: world.percept(NO_AGENT_NAME), "percept() of an unknown agent", NO_AGENT_NAME)


def _check_cycles(world: World, wandering: Wandering, cycles: int) -> None:
    """Check that cycles count, nothing becomes NaN, and an ended episode must be reset."""
    begun = 0
    for done in range(cycles):
        assert (world.cycle, world.episode_cycle) == (done, done - begun), "step() counts cycles"
        told = world.step(wandering.actions(world))
        assert (told or "") == world.ended, "step() returns why the episode ended, else None"
        assert not world.refused, f"valid actions are not refused: {dict(world.refused)}"
        for entity in world.entities():
            figures = (entity.x, entity.y, entity.heading, entity.vx, entity.vy, entity.radius)
            assert all(map(math.isfinite, figures)), f"{entity.name} is not finite: {entity}"
        result = world.result()
        assert result.cycles == world.episode_cycle, "result() counts the episode's cycles"
        assert math.isclose(result.seconds, result.cycles * world.cycle_seconds)
        if world.ended:
            _refuses(lambda: world.step({}), "step() after the end of an episode")
            episode = world.episode
            world.reset()
            begun = world.cycle
            new = (world.episode, world.ended)
            assert new == (episode + 1, ""), "reset() begins the next episode"


def _check_seeds(make: MakeWorld, wandering: Wandering, cycles: int) -> None:
    """Check that a run depends on its seed alone, and an episode on that and its number."""
    world, other, ignored = make(1), make(2), make(1)
    first = _wander(world, wandering, cycles)
    assert _wander(make(1), wandering, cycles) == first, "the same seed must give the same run"
    assert _wander(make(2), wandering, cycles) != first, "another seed should give a different run"
    for _ in range(cycles):
        _step(ignored, wandering)
    world.snapshot()
    assert _observed(world) == _observed(world), "asking again must give the same"
    assert _observed(world) == _observed(ignored), "looking must not change what happens"
    world.reset(5, 3)
    other.reset(5, 3)
    assert (world.episode, world.seed, world.episode_cycle) == (5, 3, 0), "reset(5, 3)"
    assert world.cycle == cycles, "reset() never sets back the world's own cycles"
    while not world.ended and other.cycle < cycles:
        assert _observed(world) == _observed(other), (
            "an episode must depend on seed and number alone"
        )
        actions = wandering.actions(other)
        world.step(actions)
        other.step(actions)


def _check_snapshots(make: MakeWorld, wandering: Wandering, cycles: int) -> None:
    """Check that snapshots are JSON-able and complete: a restored world continues the same."""
    world = make(1)
    for _ in range(2):  # the second time from a restored world
        _wander(world, wandering, cycles // 3)
        kept = json.loads(json.dumps(world.snapshot()))
        expected = _wander(world, wandering, cycles)
        for restored in (make(7), world):
            restored.restore(kept)
            assert _wander(restored, wandering, cycles) == expected, (
                "a restored world continues the same"
            )
        world.restore(kept)


def _check_damaged_snapshots(world: World, wandering: Wandering, cycles: int) -> None:
    """Check that a snapshot with a missing or wrong value is refused as a whole."""
    _wander(world, wandering, cycles // 3)
    kept = json.loads(json.dumps(world.snapshot()))
    _wander(world, wandering, cycles)
    before = world.snapshot()
    for what, damaged in _damaged_copies(kept):
        _refuses(partial(world.restore, damaged), f"a snapshot {what}")
        assert world.snapshot() == before, f"a snapshot {what} changes nothing"


def _damaged_copies(snapshot: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield damaged copies, each after a text that names the damage."""
    yield "of another kind of world", {**snapshot, "world": NO_AGENT_NAME}
    for key in snapshot:
        yield f'without "{key}"', {k: value for k, value in snapshot.items() if k != key}
    alike: dict[tuple[Any, ...], list[tuple[Any, ...]]] = {}
    for path in _leaves(snapshot):
        alike.setdefault(tuple(key for key in path if isinstance(key, str)), []).append(path)
    random = Random(0)
    for paths in alike.values():
        for path in random.sample(paths, min(len(paths), LIKE_EACH_OTHER)):
            damaged = part = copy.deepcopy(snapshot)
            for key in path[:-1]:
                part = part[key]
            wrong = 0.5 if isinstance(part[path[-1]], str) else "damaged"
            part[path[-1]] = wrong
            yield f"with {wrong!r} at {'/'.join(map(str, path))}", damaged


def _leaves(part: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the keys and indices that lead to each value that is no dictionary or list."""
    if isinstance(part, dict | list):
        for key, value in part.items() if isinstance(part, dict) else enumerate(part):
            yield from _leaves(value, (*path, key))
    else:
        yield path


def _check_bad_actions(make: MakeWorld, wandering: Wandering) -> None:
    """Check that a bad action counts as none, is reported by name, and affects no other agent."""
    for bad in (([math.nan] * 3, ""), ([math.inf] * 3, ""), (["fast"], ""), None, ([[1.0]], "")):
        world, idle = make(1), make(1)
        actions = wandering.actions(world)
        victim = world.agents[0]
        world.step({**actions, victim: bad})  # type: ignore[dict-item]
        idle.step({name: action for name, action in actions.items() if name != victim})
        assert victim in world.refused, f"the action {bad} is reported in `refused`"
        assert victim in world.refused[victim], "a refusal contains the agent's name"
        assert _observed(world) == _observed(idle), f"the action {bad} counts as none"
        world.reset()
        world.step({NO_AGENT_NAME: ([], "")})
        assert set(world.refused) == {NO_AGENT_NAME}, (
            "`refused` covers the last cycle, and the actions of unknown agents"
        )


def _check_bad_placements(world: World) -> None:
    """Check that nothing is placed if anything is refused."""
    agent = world.agents[0]
    before = world.snapshot()
    good = Placement(agent, 0.0, 0.0)
    for bad in (Placement(NO_AGENT_NAME, 0.0, 0.0), Placement(agent, x=math.inf)):
        _refuses(partial(world.place, [good, bad], new_episode=True), str(bad), bad.name)
        assert world.snapshot() == before, "nothing is placed if anything is refused"
    episode = world.episode
    world.place([], new_episode=True)
    assert world.episode == episode + 1, "a placement can begin a new episode"


def _refuses(call: Callable[[], object], what: str, names: str = "") -> None:
    """Check that a call raises a WorldError, which ``names`` something."""
    refused: Exception | None = None
    try:
        call()
    except Exception as error:
        refused = error
    assert isinstance(refused, WorldError), f"{what} raises a WorldError, not {refused!r}"
    assert names in str(refused), f"{what} raises a WorldError that names {names}"
