"""Swarms with commanders play the same over topics as in one process, bit for bit."""

from dataclasses import dataclass
from pathlib import Path

import pytest
from hierarchy_players import Commander, HierarchyPlayers, Member

from foraging_world.parameters import ForagingParameters
from foraging_world.world import ForagingWorld
from hitab_bringup.bringing_up import temporary_swarm
from hitab_bringup.swarm_description import SwarmDescription
from hitab_bringup.swarm_file import read_swarm
from hitab_client.shipped import find_file, shipped
from hitab_commander.commander_domain import commander_domain
from hitab_commander.kind_reader import KIND_FILE, read_kind
from hitab_core.domain import load_domain
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_world.inprocess import play
from hitab_world.world import World
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.world import KeepawayWorld

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


def foragers(folder: Path, where: str) -> SwarmDescription:
    file = folder / f"{where}.yaml"
    file.write_text(
        FORAGERS.format(libraries=shipped("libraries", "foraging").parent, **HOSTED[where])
    )
    return read_swarm(file)


def trained(library: str) -> BehaviorLibrary:
    folder = shipped("libraries", library)
    return BehaviorLibrary(folder, commander_domain(read_kind(folder / KIND_FILE)))


def commander(name: str, library: str, behavior: str, subordinates) -> Commander:
    kind = read_kind(shipped("libraries", library) / KIND_FILE)
    return Commander(name, kind, trained(library), behavior, tuple(subordinates))


@pytest.fixture(scope="module")
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


@pytest.mark.parametrize("where", [pytest.param("processes", marks=pytest.mark.long), "hosts"])
def test_three_levels_play_over_topics_as_in_one_process(
    home, tmp_path, foragers_in_process, where
):
    assert over_topics(foragers(tmp_path, where), tmp_path / "run") == foragers_in_process


@pytest.fixture(scope="module")
def keepers_in_process() -> Run:
    world = KeepawayWorld(KeepawayParameters(taker_speed=0.25), SEED)
    folder = shipped("libraries", "keepaway_captained")
    library = BehaviorLibrary(folder, load_domain("keepaway"))
    captain = commander("captain", "captain", "Captain", world.agents)
    return in_process(
        world, HierarchyPlayers([Member(name, library) for name in world.agents], [captain])
    )


def test_a_captain_and_its_keepers_play_over_topics_as_in_one_process(
    home, tmp_path, keepers_in_process
):
    swarm = read_swarm(find_file("keepaway_captain", "swarms", "swarm"))
    assert over_topics(swarm.with_world(pace="lockstep"), tmp_path) == keepers_in_process


def test_without_its_captain_the_keepers_play_another_game(keepers_in_process):
    world = KeepawayWorld(KeepawayParameters(taker_speed=0.25), SEED)
    folder = shipped("libraries", "keepaway_captained")
    library = BehaviorLibrary(folder, load_domain("keepaway"))
    alone = HierarchyPlayers([Member(name, library, "Keepaway") for name in world.agents])
    assert in_process(world, alone) != keepers_in_process
