"""Checks for any `hitab_world.world.World`, including your own.

In a test::

    from hitab_world.testing import Wandering, check_world

    def test_it_is_a_world():
        check_world(lambda seed: MyWorld(seed=seed), Wandering([[1.0, 0.0], [0.0, 0.5]]))

`check_world` calls all others; each raises an AssertionError that names the broken requirement of
the interface. The idea is that of PettingZoo's ``api_test`` and ``seed_test``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from random import Random
from typing import Any

from hitab_world.damage import damaged_copies
from hitab_world.world import Action, Entity, EpisodeResult, Look, Placement, World, WorldError

MakeWorld = Callable[[int], World]
"""Creates a world, given the seed of the run."""

NOBODY = "nobody_is_called_so"


class Wandering:
    """Varied actions for all agents; asking again in the same cycle gives the same actions.

    Args:
        samples: actions that agents can do, in the domain's own layout.
        say: what they may say, apart from nothing.
    """

    def __init__(self, samples: Sequence[Sequence[float]], say: Sequence[str] = ()) -> None:
        self._samples = [list(sample) for sample in samples]
        self._say = ["", *say]

    def actions(self, world: World) -> dict[str, Action]:
        """Return what the agents do in this cycle; about one in ten does nothing."""
        random = Random(world.cycle)
        return {
            name: (random.choice(self._samples), random.choice(self._say))
            for name in world.agents
            if random.random() > 0.1
        }


def observed(world: World) -> tuple[Any, ...]:
    """Return everything that can be seen of a world now."""
    return (
        [world.percept(name) for name in world.agents],
        world.entities(),
        world.result(),
        world.ended,
    )


def wander(world: World, wandering: Wandering, cycles: int) -> list[Any]:
    """Let the agents do varied things for some cycles; return everything that could be seen."""
    seen = [observed(world)]
    for _ in range(cycles):
        if world.ended:
            world.reset()
        world.step(wandering.actions(world))
        seen.append(observed(world))
    return seen


def check_world(make: MakeWorld, wandering: Wandering, cycles: int = 60) -> None:
    """Run all checks on a world."""
    check_interface(make(1))
    check_cycles(make(1), wandering, cycles)
    check_seeds(make, wandering, cycles)
    check_episodes(make, wandering, cycles)
    check_looking_changes_nothing(make, wandering, cycles)
    check_snapshots(make, wandering, cycles)
    check_bad_snapshots(make(1))
    check_damaged_snapshots(make(1), wandering, cycles)
    check_bad_actions(make, wandering)
    check_bad_placements(make(1))
    check_batches(make(1), wandering, cycles)


def check_interface(world: World) -> None:
    """Check that a new world has the attributes of the interface, with valid values."""
    assert isinstance(world.name, str), "name must be text"
    assert world.name, "name must not be empty"
    assert world.agents, "a world has agents"
    assert len(set(world.agents)) == len(world.agents), "names of agents must differ"
    assert world.cycle_seconds > 0.0, "cycle_seconds must be positive"
    assert len(world.size) == 2, "size is width and height"
    assert min(world.size) > 0.0, "size must be positive"
    assert (world.episode, world.cycle, world.episode_cycle) == (0, 0, 0), (
        "a new world is at the beginning of episode 0"
    )
    assert world.ended == "", "a new world has not ended"
    assert isinstance(world.result(), EpisodeResult), "result() is an EpisodeResult"
    for name in world.agents:
        values, heard = world.percept(name)
        assert all(isinstance(v, float) for v in values), f"percept of {name}: values are floats"
        assert all(isinstance(h, str) for h in heard), f"percept of {name}: messages are text"
    entities = world.entities()
    assert all(isinstance(e, Entity) for e in entities), "entities() are Entity objects"
    names = [e.name for e in entities]
    assert len(set(names)) == len(names), "names of entities must differ"
    assert set(world.agents) <= set(names), "every agent is an entity, so that it can be seen"
    assert all(isinstance(look, Look) for look in world.looks.values()), "looks are Look objects"
    refused = _refusal(lambda: world.percept(NOBODY))
    assert refused is not None, "percept() of an unknown agent raises a WorldError"
    assert NOBODY in refused, "percept() of an unknown agent names it in its error"


def check_cycles(world: World, wandering: Wandering, cycles: int) -> None:
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
            assert _refusal(lambda: world.step({})), (
                "step() after the end of an episode raises a WorldError"
            )
            episode = world.episode
            world.reset()
            assert (world.episode, world.ended) == (episode + 1, ""), (
                "reset() begins the next episode"
            )
            begun = world.cycle


def check_seeds(make: MakeWorld, wandering: Wandering, cycles: int) -> None:
    """Check that a seed gives the same run, bit for bit, and another seed a different one."""
    first = wander(make(1), wandering, cycles)
    assert wander(make(1), wandering, cycles) == first, "the same seed must give the same run"
    assert wander(make(2), wandering, cycles) != first, "another seed should give a different run"


def check_episodes(make: MakeWorld, wandering: Wandering, cycles: int) -> None:
    """Check that an episode depends only on its number and the run's seed."""
    world, other = make(1), make(2)
    wander(world, wandering, cycles)
    before = world.cycle
    world.reset(5, 3)
    assert (world.episode, world.seed, world.episode_cycle) == (5, 3, 0), "reset(5, 3)"
    assert world.cycle == before, "reset() never sets back the world's own cycles"
    other.reset(5, 3)
    for _ in range(cycles):
        assert observed(world) == observed(other), (
            "an episode must depend on seed and number alone"
        )
        if world.ended:
            return
        actions = wandering.actions(other)
        world.step(actions)
        other.step(actions)


def check_looking_changes_nothing(make: MakeWorld, wandering: Wandering, cycles: int) -> None:
    """Check that perceiving, viewing, results and snapshots do not change what happens."""
    looked, ignored = make(1), make(1)
    for _ in range(cycles):
        if looked.ended:
            looked.reset()
            ignored.reset()
        actions = wandering.actions(looked)
        assert observed(looked) == observed(looked), "asking again must give the same"
        looked.snapshot()
        looked.step(actions)
        ignored.step(actions)
    assert observed(looked) == observed(ignored), "looking must not change what happens"


def check_snapshots(make: MakeWorld, wandering: Wandering, cycles: int) -> None:
    """Check that snapshots are JSON-able and complete: a restored world continues the same."""
    world = make(1)
    for part in (cycles // 3, cycles // 3):  # the second time from a restored world
        wander(world, wandering, part)
        kept = json.loads(json.dumps(world.snapshot()))
        assert kept == json.loads(json.dumps(world.snapshot())), "asking again gives the same"
        expected = wander(world, wandering, cycles)
        world.restore(kept)
        assert wander(world, wandering, cycles) == expected, "a restored world continues the same"
        fresh = make(7)
        fresh.restore(kept)
        assert wander(fresh, wandering, cycles) == expected, "in another world as well"
        world.restore(kept)


def check_bad_snapshots(world: World) -> None:
    """Check that an invalid snapshot is refused and changes nothing."""
    before = world.snapshot()
    assert _refusal(lambda: world.restore({})), "an empty snapshot raises a WorldError"
    assert _refusal(lambda: world.restore({**before, "world": NOBODY})), (
        "the snapshot of another kind of world raises a WorldError"
    )
    assert world.snapshot() == before, "a refused snapshot changes nothing"


def check_damaged_snapshots(world: World, wandering: Wandering, cycles: int) -> None:
    """Check that a snapshot with a missing or wrong value is refused as a whole."""
    wander(world, wandering, cycles // 3)
    kept = json.loads(json.dumps(world.snapshot()))
    wander(world, wandering, cycles)
    before = world.snapshot()
    for what, damaged in damaged_copies(kept):
        try:
            refused = _refusal(lambda damaged=damaged: world.restore(damaged))  # type: ignore[misc]
        except Exception as error:
            raise AssertionError(f"a snapshot {what} raises a WorldError") from error
        assert refused, f"a snapshot {what} raises a WorldError"
        assert world.snapshot() == before, f"a snapshot {what} changes nothing"


def check_bad_actions(make: MakeWorld, wandering: Wandering) -> None:
    """Check that a bad action counts as none, is reported by name, and affects no other agent."""
    for bad in (([math.nan] * 3, ""), ([math.inf] * 3, ""), (["fast"], ""), None, ([[1.0]], "")):
        world, idle = make(1), make(1)
        actions = wandering.actions(world)
        victim = world.agents[0]
        world.step({**actions, victim: bad})  # type: ignore[dict-item]
        idle.step({name: action for name, action in actions.items() if name != victim})
        assert victim in world.refused, f"the action {bad} is reported in `refused`"
        assert victim in world.refused[victim], "a refusal contains the agent's name"
        assert observed(world) == observed(idle), f"the action {bad} counts as none"
        world.reset()
        world.step({})
        assert not world.refused, "`refused` covers the last cycle only"
    world = make(1)
    world.step({NOBODY: ([], "")})
    assert NOBODY in world.refused, "the action of an unknown agent is reported in `refused`"


def check_bad_placements(world: World) -> None:
    """Check that nothing is placed if anything is refused."""
    agent = world.agents[0]
    before = world.snapshot()
    good = Placement(agent, 0.0, 0.0)
    for bad in (Placement(NOBODY, 0.0, 0.0), Placement(agent, x=math.inf)):
        refused = _refusal(lambda bad=bad: world.place([good, bad], new_episode=True))  # type: ignore[misc]
        assert refused is not None, f"{bad} raises a WorldError"
        assert bad.name in refused, f"the refusal of {bad} names it"
        assert world.snapshot() == before, "nothing is placed if anything is refused"
    episode = world.episode
    world.place([], new_episode=True)
    assert world.episode == episode + 1, "a placement can begin a new episode"


def check_batches(world: World, wandering: Wandering, cycles: int) -> None:
    """Check that all percepts at once, if a world offers them, equal those one by one."""
    percepts = getattr(world, "percepts", None)
    if percepts is None:
        return
    for _ in range(min(cycles, 10)):
        if world.ended:
            world.reset()
        world.step(wandering.actions(world))
        rows = percepts().tolist()
        assert rows == [world.percept(name)[0] for name in world.agents], (
            "percepts() has a row for each agent, in the order of `agents`"
        )


def _refusal(call: Callable[[], object]) -> str | None:
    """Return the text of a WorldError, or None if none is raised."""
    try:
        call()
    except WorldError as error:
        return str(error)
    return None
