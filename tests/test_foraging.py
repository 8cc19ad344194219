"""Foragers and their commanders over real topics: as in one process, and as they were taught."""

from pathlib import Path

import pytest

from foraging_world.parameters import ForagingParameters
from foraging_world.world import ForagingWorld
from hitab_bringup.bringing_up import temporary_swarm
from hitab_bringup.swarm_file import read_swarm
from hitab_client.lessons.lesson_file import read_lesson
from hitab_client.lessons.lesson_player import LessonPlayer
from hitab_client.shipped import find_file, shipped
from hitab_client.world_client import WorldClient
from hitab_commander.commander_domain import commander_domain
from hitab_commander.kind_reader import KIND_FILE, read_kind
from hitab_core.domain import load_domain
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.repertoire import Repertoire
from hitab_world.inprocess import cycle, perform

CYCLES = 300
LESSONS = ("foraging_search", "foraging_goto", "foraging_carry", "foraging_forage")


def places(entities) -> dict[str, tuple[float, float]]:
    return {e.name: (e.x, e.y) for e in entities}


def step(world: WorldClient, cycles: int):
    """Step in parts, so that the answer comes in time on a busy machine."""
    for _ in range(cycles // 50):
        state = world.step(50, seconds=60.0)
    return state


def test_foragers_do_over_topics_what_they_do_in_one_process(home, tmp_path):
    described = read_swarm(find_file("foraging", "swarms", "swarm"))
    described = described.with_world(pace="lockstep", paused=True)
    with temporary_swarm(described, tmp_path) as running:
        told = places(step(running.world, CYCLES).entities)
        assert running.world.status.missed_deadlines == 0
        seed = running.world.status.seed
    figures = ForagingParameters.from_dict(dict(described.world.parameters))
    world = ForagingWorld(figures, seed)
    library = BehaviorLibrary(shipped("libraries", "foraging"), load_domain("foraging"))
    players = perform(world, Repertoire(library.domain, library.load()), "Forage")
    for player in players.values():
        player.begin(world.seed, world.episode)
    for _ in range(CYCLES):
        cycle(world, players)
    assert told == places(world.entities())


@pytest.mark.long
def test_the_foragers_lessons_teach_what_is_shipped(home, tmp_path):
    described = read_swarm(find_file("foraging_school", "swarms", "swarm"))
    with temporary_swarm(described, tmp_path) as running:
        for name in LESSONS:
            lesson = read_lesson(find_file(name, "lessons", "lesson"))
            report = LessonPlayer(lesson, running.agents, running.world).play()
            assert 0 < report.examples <= lesson.budget
        taught = examples_of(Path(report.path).parent, load_domain("foraging"))
    assert taught == examples_of(shipped("libraries", "foraging"), load_domain("foraging"))


@pytest.mark.long
@pytest.mark.parametrize("taught_commander", ["foraging_squad", "foraging_company"])
def test_commanders_learn_from_their_lessons_what_is_shipped(home, tmp_path, taught_commander):
    name = taught_commander
    folder = shipped("libraries", name)
    domain = commander_domain(read_kind(folder / KIND_FILE))
    described = read_swarm(find_file(f"{name}_school", "swarms", "swarm"))
    with temporary_swarm(described, tmp_path) as running:
        read = read_lesson(find_file(name, "lessons", "lesson"))
        report = LessonPlayer(read, running.agents, running.world).play()
        assert 0 < report.examples <= read.budget
        taught = examples_of(Path(report.path).parent, domain)
    assert taught == examples_of(folder, domain)


def examples_of(folder: Path, domain) -> dict[str, list[tuple]]:
    loaded = BehaviorLibrary(folder, domain).load()
    return {
        name: [(e.state, e.features, e.next_state, e.kind) for e in automaton.examples]
        for name, automaton in loaded.items()
    }
