"""Keepers for takers at full speed: what their lessons teach, and that it is what is shipped."""

from pathlib import Path

import pytest
from taught import examples_of

from hitab_bringup.bringing_up import temporary_swarm
from hitab_bringup.opened_library import open_library
from hitab_client.lessons.lesson_file import read_lesson
from hitab_client.lessons.lesson_player import LessonPlayer
from hitab_client.shipped import find_file, shipped
from hitab_core import Repertoire
from hitab_world.inprocess import perform, play
from keepaway_world.parameters import variant
from keepaway_world.verbs.evaluation import trained_keepers
from keepaway_world.world import KeepawayWorld

LESSONS = ("play_ball", "keepaway")
MOST_EXAMPLES = 60
FULL_SPEED = {"taker_speed": 1.0, "ball_collides": True}
LIBRARY = shipped("libraries", "keepaway_fullspeed")


@pytest.fixture(scope="module")
def learned(home, tmp_path_factory):
    """Return what keeper_1 has learned from the lessons."""
    folder = tmp_path_factory.mktemp("fullspeed")
    swarm = trained_keepers(None, "", FULL_SPEED, domain="keepaway_fullspeed")
    with temporary_swarm(swarm, folder) as running:
        for name in LESSONS:
            lesson = read_lesson(find_file(f"fullspeed/{name}", "lessons", "lesson"))
            report = LessonPlayer(lesson, running.agents, running.world).play()
        return examples_of(Path(report.path).parent)


@pytest.mark.long
def test_what_is_shipped_is_what_the_lessons_teach_with_at_most_sixty_examples(learned):
    assert learned == examples_of(LIBRARY)
    assert sum(len(of_one) for of_one in learned.values()) <= MOST_EXAMPLES


def test_they_last_longer_than_keepers_that_know_distances_only():
    """Half of the others' episodes are over after ten seconds, so twenty of each tell enough."""

    def cycles(library: str) -> int:
        opened = open_library(shipped("libraries", library))
        game = variant("standard", sight="quantised", taker_policy="reference")
        world = KeepawayWorld(game, seed=3)
        players = perform(world, Repertoire(opened.domain, opened.load()), "Keepaway")
        return sum(played.cycles for played in play(world, players, 6, cycles_max=200))

    assert cycles("keepaway_fullspeed") >= 1.3 * cycles("keepaway_predictive")
