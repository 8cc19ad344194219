"""In lockstep the same seed gives the same run, bit for bit, wherever the agents run."""

import multiprocessing
import os
import signal
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from hitab_msgs.msg import WorldState
from hitab_msgs.srv import Control

from hitab_bringup.casting import Cast
from hitab_bringup.evaluation import games_of
from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm
from hitab_bringup.swarm_files.swarm_description import SwarmDescription
from hitab_bringup.swarm_files.swarm_file import read_swarm
from hitab_client.runs.run_processes import process_states
from hitab_client.runs.shipped import find_file, shipped
from hitab_client.showing.commander_view import CommanderView
from hitab_world.inprocess import play

SEED = 11
EPISODES = 2

FORAGERS = """\
swarm: foragers
domain: foraging
start_from: {libraries}/foraging
world:
  kind: foraging
  pace: lockstep
  parameters: {{foragers: 8, small_boxes: 6, large_boxes: 2, duration: 20.0}}
agents:
  forager: {{count: 8{where}}}
kinds:
  Squad: {libraries}/foraging_squad/commander.yaml
  Company: {libraries}/foraging_company/commander.yaml
commanders:
  squad: {{kind: Squad, commands: {{forager: 4}}, start_from: {libraries}/foraging_squad{host}}}
  company:
    kind: Company
    commands: squad
    start_from: {libraries}/foraging_company
    behavior: CompanyForage
    {host_of_company}
"""

HOSTED = {
    "processes": {"where": "", "host": "", "host_of_company": ""},
    # Agents in two hosts, one of them with commanders, the others elsewhere.
    "hosts": {
        "where": ", per_process: 5",
        "host": ", host: command",
        "host_of_company": "host: command",
    },
}


@dataclass(frozen=True)
class Run:
    """What came of a run: figures of its episodes, and where everything is at its end."""

    episodes: tuple[tuple[object, ...], ...]
    places: tuple[tuple[object, ...], ...]


def places(entities) -> tuple[tuple[object, ...], ...]:
    return tuple((e.name, e.x, e.y, e.heading, e.vx, e.vy) for e in entities)


def over_topics(swarm: SwarmDescription, folder: Path) -> Run:
    """Play two whole episodes and the beginning of a third."""
    with temporary_swarm(swarm.with_world(paused=True), folder) as running:
        episodes = running.world.play(EPISODES, seed=SEED)
        state = running.world.step(30, seconds=60.0)
        status = running.world.status
    assert status is not None
    assert status.missed_deadlines == 0
    assert status.reproducible
    assert all(episode.reproducible for episode in episodes)
    return Run(
        tuple(
            (e.number, e.seed, e.cycles, e.ended, *(m.value for m in e.measures)) for e in episodes
        ),
        places(state.entities),
    )


def in_process(swarm: SwarmDescription, *behaviors: str) -> Run:
    """Play the same as `hitab evaluate` does, with other behaviors than the swarm's if given."""
    cast = Cast(swarm)
    cast.choose_behaviors(behaviors)
    with games_of(swarm.with_world(seed=SEED), [cast.parts()]) as ((world, players, between),):
        results = play(world, players, EPISODES, between=between)
        play(world, players, cycles_max=30, between=between)
        return Run(
            tuple((r.number, r.seed, r.cycles, r.ended, *r.measures.values()) for r in results),
            places(world.entities()),
        )


def foragers(folder: Path, where: str) -> SwarmDescription:
    file = folder / f"{where}.yaml"
    file.write_text(
        FORAGERS.format(libraries=shipped("libraries", "foraging").parent, **HOSTED[where])
    )
    return read_swarm(file)


@pytest.mark.long
@pytest.mark.parametrize("where", HOSTED)
def test_three_levels_play_over_topics_as_in_one_process(home, tmp_path, where):
    swarm = foragers(tmp_path, where)
    assert over_topics(swarm, tmp_path / "run") == in_process(swarm)


@pytest.fixture(scope="module")
def captained(home, tmp_path_factory) -> Run:
    return over_topics(keepers_with_captain(), tmp_path_factory.mktemp("captained"))


def keepers_with_captain() -> SwarmDescription:
    return read_swarm(find_file("keepaway_captain", "swarms", "swarm")).with_world(pace="lockstep")


def test_a_captain_and_its_keepers_play_over_topics_as_in_one_process(captained):
    swarm = keepers_with_captain()
    assert captained == in_process(swarm)
    assert captained != in_process(swarm, "Keepaway"), "without its captain"


@pytest.fixture
def busy() -> Iterator[None]:
    """Two processes for each processor that do nothing but keep it busy."""
    spawn = multiprocessing.get_context("spawn")
    loops = [spawn.Process(target=_keep_busy) for _ in range(2 * multiprocessing.cpu_count())]
    for loop in loops:
        loop.start()
    yield
    for loop in loops:
        loop.kill()
        loop.join()


def _keep_busy() -> None:
    while True:
        pass


@pytest.mark.long
def test_a_busy_machine_changes_nothing(tmp_path, captained, busy):
    assert over_topics(keepers_with_captain(), tmp_path) == captained


@pytest.mark.long
@pytest.mark.parametrize("lossy", [100], indirect=True)
def test_lost_datagrams_cost_no_deadlines(tmp_path, captained, lossy):
    """Two that were lost in one cycle cost one: each was sent again only after 3 s."""
    assert over_topics(keepers_with_captain(), tmp_path / "run") == captained


@pytest.mark.parametrize("comes", ["at once", pytest.param("late", marks=pytest.mark.long)])
@pytest.mark.parametrize("name", ["captain", pytest.param("keeper_2", marks=pytest.mark.long)])
def test_who_is_killed_costs_deadlines_marks_the_run_and_comes_back(home, tmp_path, name, comes):
    swarm = read_swarm(find_file("keepaway_captain", "swarms", "swarm"))
    with temporary_swarm(swarm.with_world(pace="lockstep", paused=True), tmp_path) as running:
        view = CommanderView(running.agents)
        view.watch(["captain"])
        running.world.control(Control.Request.STEP, cycles=10_000)
        assert running.link.spin_until(lambda: running.world.status.cycle > 20, 60.0)
        killed = view.groups["captain"].epoch if name == "captain" else 0
        successor = kill(running, name)
        if comes == "late":  # after the deadline
            os.kill(successor, signal.SIGSTOP)
        assert running.link.spin_until(lambda: not running.world.status.reproducible, 60.0)
        assert running.world.status.missed_deadlines > 0
        running.world.control(Control.Request.PAUSE)

        def is_back() -> bool:
            os.kill(successor, signal.SIGCONT)
            if running.world.status.missing or view.incomplete:
                return False
            # What the killed captain said last says nothing of the one that took its place.
            return view.groups["captain"].epoch != killed

        def steps_until_back() -> bool:
            running.world.step(1, seconds=60.0)
            return is_back()

        assert running.link.spin_until(steps_until_back, 60.0)
        missed = running.world.status.missed_deadlines
        running.world.step(20, seconds=60.0)
        assert running.world.status.missed_deadlines == missed
        assert not running.world.status.reproducible
        (episode,) = running.world.play(1, seed=SEED)
        assert episode.reproducible, "another run has begun"


def test_who_steps_a_world_gets_no_cycle_without_an_agent_that_is_slow(home, tmp_path):
    swarm = read_swarm(find_file("keepaway", "swarms", "swarm"))
    swarm = swarm.with_world(pace="lockstep", paused=True)
    with temporary_swarm(swarm, tmp_path) as running:
        world = running.world
        assert running.link.spin_until(lambda: not world.missing, 60.0)
        before = world.step(1).cycle
        slow = pid_of(running, "keeper_1")
        os.kill(slow, signal.SIGSTOP)
        try:
            world.control(Control.Request.STEP, cycles=2)
            assert running.link.spin_until(
                lambda: "waits for keeper_1" in world.status.last_error, 20.0
            )
            assert world.status.cycle == before
        finally:
            os.kill(slow, signal.SIGCONT)
        assert world.state_at(before + 2).cycle == before + 2
        assert running.link.spin_until(lambda: world.status.cycle == before + 2, 20.0)
        assert world.status.missed_deadlines == 0
        world.control(Control.Request.RESUME)
        assert running.link.spin_until(lambda: world.status.cycle > before + 20, 60.0)
        assert world.shown(world.control(Control.Request.PAUSE)).mode == WorldState.PAUSED


def pid_of(running: RunningSwarm, name: str) -> int:
    (state,) = [s for s in process_states(running.record) if s["name"] == name]
    return state["pid"]


def kill(running: RunningSwarm, name: str) -> int:
    """Kill a process and return the one that takes its place."""
    killed = pid_of(running, name)
    os.kill(killed, signal.SIGKILL)
    assert running.link.spin_until(lambda: pid_of(running, name) not in (0, killed), 20.0)
    return pid_of(running, name)
