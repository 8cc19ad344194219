"""In lockstep the same seed gives the same run, bit for bit, wherever the agents run."""

import os
import signal
from dataclasses import dataclass
from pathlib import Path

import pytest
from hitab_msgs.msg import WorldState
from hitab_msgs.srv import Control
from waiting import hanging, pid_of

from foraging_world.parameters import ForagingParameters
from foraging_world.world import ForagingWorld
from hitab_bringup.bringing_up import RunningSwarm, temporary_swarm
from hitab_bringup.swarm_description import SwarmDescription
from hitab_bringup.swarm_file import parse_swarm, read_swarm
from hitab_client.command_view import CommandView
from hitab_client.shipped import find_file, shipped
from hitab_commander.commander_domain import commander_domain
from hitab_commander.hierarchy_players import Commander, HierarchyPlayers, Member
from hitab_commander.kind_reader import KIND_FILE, read_kind
from hitab_core.domain import load_domain
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_world.inprocess import play
from hitab_world.world import World
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.world import KeepawayWorld

SEED = 11
EPISODES = 2

# Agents in two hosts, one of them with commanders, the others elsewhere.
FORAGERS = """\
swarm: foragers
domain: foraging
start_from: {libraries}/foraging
world:
  kind: foraging
  pace: lockstep
  parameters: {{foragers: 8, small_boxes: 6, large_boxes: 2, duration: 20.0}}
agents:
  forager: {{count: 8, per_process: 5}}
kinds:
  Squad: {libraries}/foraging_squad/commander.yaml
  Company: {libraries}/foraging_company/commander.yaml
commanders:
  squad:
    kind: Squad
    commands: {{forager: 4}}
    start_from: {libraries}/foraging_squad
    host: command
  company:
    kind: Company
    commands: squad
    start_from: {libraries}/foraging_company
    behavior: CompanyForage
    host: command
"""


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
        tuple((e.number, e.seed, e.cycles, e.ended, *e.measures) for e in episodes),
        places(state.entities),
    )


def in_process(world: World, hierarchy: HierarchyPlayers) -> Run:
    results = play(world, hierarchy.players, EPISODES, between=hierarchy.confer)
    play(world, hierarchy.players, cycles_max=30, between=hierarchy.confer)
    return Run(
        tuple((r.number, r.seed, r.cycles, r.ended, *r.measures.values()) for r in results),
        places(world.entities()),
    )


def trained(library: str) -> BehaviorLibrary:
    folder = shipped("libraries", library)
    return BehaviorLibrary(folder, commander_domain(read_kind(folder / KIND_FILE)))


def commander(name: str, library: str, behavior: str, subordinates) -> Commander:
    kind = read_kind(shipped("libraries", library) / KIND_FILE)
    return Commander(name, kind, trained(library), behavior, tuple(subordinates))


def foragers_in_process() -> Run:
    figures = {"foragers": 8, "small_boxes": 6, "large_boxes": 2, "duration": 20.0}
    world = ForagingWorld(ForagingParameters.from_dict(figures), SEED)
    library = BehaviorLibrary(shipped("libraries", "foraging"), load_domain("foraging"))
    squads = [
        commander(f"squad_{i + 1}", "foraging_squad", "", world.agents[4 * i : 4 * i + 4])
        for i in range(2)
    ]
    names = [squad.name for squad in squads]
    company = commander("company", "foraging_company", "CompanyForage", names)
    members = [Member(name, library) for name in world.agents]
    return in_process(world, HierarchyPlayers(members, [*squads, company]))


def test_three_levels_play_over_topics_as_in_one_process(home, tmp_path):
    text = FORAGERS.format(libraries=shipped("libraries", "foraging").parent)
    swarm = parse_swarm(text, tmp_path / "foragers.yaml")
    assert over_topics(swarm, tmp_path / "run") == foragers_in_process()


def keepers_in_process() -> Run:
    world = KeepawayWorld(KeepawayParameters(taker_speed=0.25), SEED)
    folder = shipped("libraries", "keepaway_captained")
    library = BehaviorLibrary(folder, load_domain("keepaway"))
    captain = commander("captain", "captain", "Captain", world.agents)
    return in_process(
        world, HierarchyPlayers([Member(name, library) for name in world.agents], [captain])
    )


def captained(**options: object) -> SwarmDescription:
    return read_swarm(find_file("keepaway_captain", "swarms", "swarm")).with_world(**options)


def test_a_captain_and_its_keepers_play_over_topics_as_in_one_process(home, tmp_path):
    assert over_topics(captained(pace="lockstep"), tmp_path) == keepers_in_process()


@pytest.mark.parametrize("lossy", [100], indirect=True)
def test_lost_datagrams_cost_no_deadlines(home, tmp_path, lossy):
    """Two that were lost in one cycle cost one: each was sent again only after 3 s."""
    swarm = captained(pace="lockstep", paused=True)
    with temporary_swarm(swarm, tmp_path / "run") as running:
        for _ in range(5):
            running.world.step(20, seconds=60.0)
        assert running.world.status.missed_deadlines == 0
        assert running.world.status.reproducible


@pytest.mark.parametrize("name", ["captain", pytest.param("keeper_2", marks=pytest.mark.long)])
def test_who_is_killed_costs_deadlines_marks_the_run_and_comes_back(home, tmp_path, name):
    with temporary_swarm(captained(pace="lockstep", paused=True), tmp_path) as running:
        view = CommandView(running.link)
        view.watch(["captain"])
        running.world.control(Control.Request.STEP, cycles=10_000)
        assert running.link.spin_until(lambda: running.world.status.cycle > 20, 60.0)
        killed = view.groups["captain"].epoch if name == "captain" else 0
        successor = kill(running, name)
        os.kill(successor, signal.SIGSTOP)  # until after the deadline
        assert running.link.spin_until(lambda: not running.world.status.reproducible, 60.0)
        assert running.world.status.missed_deadlines > 0
        running.world.control(Control.Request.PAUSE)

        def is_back() -> bool:
            os.kill(successor, signal.SIGCONT)
            if running.world.status.missing or view.incomplete(["captain"]):
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
        with hanging(running, "keeper_1"):
            world.control(Control.Request.STEP, cycles=2)
            assert running.link.spin_until(
                lambda: "waits for keeper_1" in world.status.last_error, 20.0
            )
            assert world.status.cycle == before
        assert world.state_at(before + 2).cycle == before + 2
        assert running.link.spin_until(lambda: world.status.cycle == before + 2, 20.0)
        assert world.status.missed_deadlines == 0
        world.control(Control.Request.RESUME)
        assert running.link.spin_until(lambda: world.status.cycle > before + 20, 60.0)
        assert world.shown(world.control(Control.Request.PAUSE)).mode == WorldState.PAUSED


def kill(running: RunningSwarm, name: str) -> int:
    """Kill a process and return the one that takes its place."""
    killed = pid_of(running, name)
    os.kill(killed, signal.SIGKILL)
    assert running.link.spin_until(lambda: pid_of(running, name) not in (0, killed), 20.0)
    return pid_of(running, name)
