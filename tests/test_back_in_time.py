"""Worlds go back in time with their agents and commanders, and play the same again."""

from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import pytest
from keepers import trained_keepers

from hitab_bringup.evaluation import world_of
from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm
from hitab_bringup.swarm_files.swarm_description import SwarmDescription
from hitab_bringup.swarm_files.swarm_file import read_swarm
from hitab_client import SwarmError
from hitab_client.runs.shipped import find_file, shipped
from hitab_core.operations import BeginTraining, DiscardTraining, Perform, SetBreakpoints
from hitab_world.simulating.last_minute import LastMinute
from hitab_world.world import Placement

ONE, TWO = "keeper_1", "keeper_2"

HOSTED = """\
swarm: foragers
domain: foraging
start_from: {libraries}/foraging
world:
  kind: foraging
  pace: lockstep
  paused: true
  parameters: {{foragers: 6, small_boxes: 4, large_boxes: 1, duration: 30.0}}
agents:
  forager: {{count: 6, per_process: 4}}
kinds:
  Squad: {libraries}/foraging_squad/commander.yaml
commanders:
  squad:
    kind: Squad
    commands: {{forager: 6}}
    start_from: {libraries}/foraging_squad
    host: command
    behavior: SquadForage
"""


# -- worlds ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "values"), [("keepaway", 3), ("foraging", 3)])
def test_a_world_that_goes_back_plays_the_same_again(kind, values):
    random = Random(3)
    swarm = read_swarm(find_file(kind, "swarms", "swarm")).with_world(seed=4)
    with world_of(swarm.world) as world:
        minute = LastMinute(world)
        snapshots: dict[int, Any] = {}
        actions: dict[int, Any] = {}

        def play(cycles: int) -> None:
            for _ in range(cycles):
                cycle = world.cycle
                snapshots[cycle] = world.snapshot()
                given = {
                    name: ([random.uniform(-1.0, 1.0) for _ in range(values)], "ho" * (cycle % 3))
                    for name in world.agents
                }
                minute.note(actions.setdefault(cycle, given))
                if world.step(actions[cycle]):
                    world.reset()

        def place() -> None:
            world.place([Placement(world.agents[0], x=0.5, y=0.5)])
            minute.cut()

        play(5)
        while world.episode_cycle < 10 or world.episode_cycle > 30:
            play(1)
        middle = world.cycle
        place()
        play(5)
        last, first = world.cycle, dict(snapshots)
        for _ in range(10):
            cycle = random.randint(minute.oldest, world.cycle - 1)
            minute.go_back(cycle)
            assert world.snapshot() == first[cycle]
            if cycle < middle:
                play(middle - cycle)
                place()
            play(last - world.cycle)
            assert {c: snapshots[c] for c in first} == first
        place()
        placed = world.snapshot()
        minute.go_back(world.cycle)
        assert world.snapshot() == placed, "what was placed in the present cycle stays"


# -- swarms ---------------------------------------------------------------------------------------


def hosted(folder: Path) -> SwarmDescription:
    file = folder / "foragers.yaml"
    file.write_text(HOSTED.format(libraries=shipped("libraries", "foraging").parent))
    return read_swarm(file)


def captained(folder: Path) -> SwarmDescription:
    swarm = read_swarm(find_file("keepaway_captain", "swarms", "swarm"))
    return swarm.with_world(pace="lockstep", paused=True, seed=7)


def seen(running: RunningSwarm, cycle: int) -> Any:
    """Step the world to a cycle; return where everything is, and what everybody does."""
    world, agents = running.world, running.agents
    state = world.step(cycle - world.status.cycle, seconds=60.0)
    places = [(e.name, e.x, e.y, e.heading, e.vx, e.vy) for e in state.entities]
    doing = {name: [*agents.read_features(name).active_path] for name in world.status.agents}
    return places, doing


@pytest.mark.parametrize("described", [captained, hosted])
def test_a_swarm_with_a_commander_goes_back_and_does_the_same_again(home, tmp_path, described):
    with temporary_swarm(described(tmp_path), tmp_path / "run") as running:
        world = running.world
        assert running.link.spin_until(lambda: not world.missing, 60.0)
        world.shown(world.control("pause"))
        world.shown(world.control("reset"))  # else the episode may end in between
        begun = world.status.cycle
        cycles = [begun + more for more in (10, 25, 26, 40, 60)]
        first = {cycle: seen(running, cycle) for cycle in cycles}
        for to in (cycles[1], cycles[0], cycles[2]):
            state = world.go_back(to=to)
            assert state.cycle == to
            assert {cycle: seen(running, cycle) for cycle in cycles if cycle > to} == {
                cycle: it for cycle, it in first.items() if cycle > to
            }
        assert world.status.missed_deadlines == 0


@pytest.fixture(scope="module")
def keepers(home: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningSwarm]:
    described = trained_keepers(shipped("libraries", "keepaway"), "Keepaway", {})
    with temporary_swarm(described, tmp_path_factory.mktemp("keepers")) as running:
        running.folder.write(running.record, register=True)
        assert running.link.spin_until(lambda: not running.world.missing, 60.0)
        yield running


@pytest.fixture
def playing(keepers: RunningSwarm) -> Iterator[RunningSwarm]:
    """Keepers that play in a paused world, in lockstep, without breakpoints."""
    world = keepers.world
    world.control("pace", pace="lockstep", factor=1.0)
    world.shown(world.control("reset"))
    world.step(5)
    yield keepers
    for name in world.status.agents:
        keepers.agents.do(name, SetBreakpoints(()))
    world.control("pause")


def change_of(running: RunningSwarm, agent: str) -> str:
    """Step until an agent enters another state of its top level; return that."""

    def state() -> str:
        return str(running.agents.read_features(agent).active_path[0])

    running.world.step(1)
    present = state()
    for _ in range(100):
        running.world.step(1)
        if (now := state()) != present:
            return now
    raise AssertionError(f"{agent} stays in {present}")


def test_steps_end_at_a_breakpoint_and_go_on_past_it(playing, hitab):
    world, agents = playing.world, playing.agents
    begun = world.step(1).cycle
    state = change_of(playing, ONE)
    reached = world.status.cycle
    world.go_back(to=begun)
    agents.do(ONE, SetBreakpoints((state,)))
    done = hitab("world", "step", "100")
    text = done.stderr
    assert done.returncode == 1
    assert f"rests at cycle {reached - 1}: {ONE}: " in text
    assert f"-> {state}" in text
    assert "hitab world resume" in text
    assert f"is held by {ONE}: " in hitab("status").stdout
    assert world.step(1).cycle == reached, "it is met once"
    assert agents.read_features(ONE).active_path[0] == state


def test_breakpoints_may_be_cleared_while_they_hold_the_world(playing):
    world, agents = playing.world, playing.agents
    begun = world.step(1).cycle
    state = change_of(playing, ONE)
    reached = world.status.cycle
    world.go_back(to=begun)
    agents.do(ONE, SetBreakpoints((state,)))
    with pytest.raises(SwarmError, match=f"rests at cycle {reached - 1}"):
        world.step(100)
    agents.do(ONE, SetBreakpoints(()))
    assert world.step(3).cycle == reached + 2
    assert not world.status.held


def test_two_agents_hold_the_world_in_the_same_cycle(playing):
    world, agents = playing.world, playing.agents
    for agent in (ONE, TWO):
        agents.do(agent, Perform("Keepaway"))
    begun = world.status.cycle
    for agent in (ONE, TWO):
        agents.do(agent, SetBreakpoints([b.name for b in agents.vocabulary(agent).behaviors]))
    world.shown(world.control("reset"))
    with pytest.raises(SwarmError, match=f"{ONE}: Start -> .*; {TWO}: Start -> "):
        world.step(3)
    assert world.status.cycle == begun


def test_an_evaluation_that_is_held_says_so(playing):
    playing.agents.do(
        ONE, SetBreakpoints([b.name for b in playing.agents.vocabulary(ONE).behaviors])
    )
    with pytest.raises(SwarmError, match=f"has played 0 of 2 episodes, but rests at.*{ONE}: "):
        playing.world.play(2, seed=1)


def test_the_verb_goes_back_by_seconds_or_to_a_cycle(playing, hitab):
    world = playing.world
    seconds = world.status.stamp.sec + world.status.stamp.nanosec * 1e-9
    each = seconds / world.status.cycle
    last = world.step(40).cycle
    assert hitab("back", str(20 * each)).stdout == f"back at cycle {last - 20}, paused\n"
    assert hitab("back", "--to", str(last - 30)).stdout == f"back at cycle {last - 30}, paused\n"
    assert playing.link.spin_until(lambda: world.status.cycle == last - 30, 10.0)
    world.control("pace", pace="realtime", factor=1.0)  # so that the episode does not end
    world.control("resume")
    refused = hitab("back", "--to", str(last + 100_000))
    assert refused.returncode == 1
    assert "is not one of the last minute of this episode; choose one from" in refused.stderr
    assert playing.link.spin_until(lambda: world.status.mode == "running", 10.0)
    assert hitab("back", "500").returncode == 1
    assert playing.link.spin_until(lambda: world.status.mode == "running", 10.0)
    assert hitab("back").returncode == 2


def test_a_world_is_slower_while_an_agent_is_taught(playing, hitab):
    world, agents = playing.world, playing.agents
    assert hitab("world", "pace", "realtime", "--factor", "4").returncode == 0
    done = hitab("world", "pace", "--teaching", "0.25")
    assert done.stdout == "pace while an agent is taught: 0.25 of the usual\n"
    assert playing.link.spin_until(lambda: world.status.teaching == 0.25, 10.0)
    agents.do(ONE, BeginTraining("Slow", features=["DistanceTo(ball)"], discard=True))
    world.control("resume")
    assert playing.link.spin_until(lambda: world.status.taught, 10.0)
    assert "realtime x 4 x 0.25 while an agent is taught" in hitab("status").stdout
    agents.do(ONE, DiscardTraining())
    agents.do(ONE, Perform("Keepaway"))
    assert playing.link.spin_until(lambda: not world.status.taught, 10.0)
    assert hitab("world", "pace").returncode == 2
