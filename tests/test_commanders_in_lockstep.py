"""Swarms with commanders play the same over topics as in one process, bit for bit."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from hitab_bringup.bringing_up import temporary_swarm
from hitab_bringup.evaluating import Cast, games_of
from hitab_bringup.swarm_description import SwarmDescription
from hitab_bringup.swarm_file import read_swarm
from hitab_client.shipped import find_file, shipped
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
        tuple((e.number, e.seed, e.cycles, e.ended, *e.measures) for e in episodes),
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
@pytest.mark.parametrize("where", ["processes", "hosts"])
def test_three_levels_play_over_topics_as_in_one_process(home, tmp_path, where):
    swarm = foragers(tmp_path, where)
    assert over_topics(swarm, tmp_path / "run") == in_process(swarm)


def test_a_captain_and_its_keepers_play_over_topics_as_in_one_process(home, tmp_path):
    swarm = read_swarm(find_file("keepaway_captain", "swarms", "swarm")).with_world(
        pace="lockstep"
    )
    played = over_topics(swarm, tmp_path)
    assert played == in_process(swarm)
    assert played != in_process(swarm, "Keepaway"), "without its captain"
