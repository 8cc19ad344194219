"""What the lessons beyond the paper teach is what is shipped, and it is worth its words."""

from pathlib import Path

import pytest
from keepers import played as played_by
from keepers import trained_keepers
from taught import examples_of

from hitab_bringup.processes.bringing_up import temporary_swarm
from hitab_client.lessons.lesson import read_lesson
from hitab_client.lessons.lesson_player import LessonPlayer
from hitab_client.runs.shipped import find_file, shipped

SLOW = {"taker_speed": 0.25}
FULL_SPEED = {"taker_speed": 1.0, "ball_collides": True}
UT_HAND_S = 53.5
"""Mean hold time of UT Austin's hand-coded keepers against quarter-speed takers, s."""


@pytest.mark.parametrize(
    ("of", "game", "lessons"),
    [
        ("predictive", SLOW, ("take_ball", "pass_ball", "play_ball", "keepaway")),
        pytest.param("fullspeed", FULL_SPEED, ("play_ball", "keepaway"), marks=pytest.mark.long),
    ],
)
def test_what_is_shipped_is_what_the_lessons_teach(home, tmp_path, of, game, lessons):
    swarm = trained_keepers(None, "", game, domain=f"keepaway_{of}")
    with temporary_swarm(swarm, tmp_path) as running:
        for name in lessons:
            lesson = read_lesson(find_file(f"{of}/{name}", "lessons", "lesson"))
            report = LessonPlayer(lesson, running.agents, running.world).play()
    assert examples_of(Path(report.path).parent) == examples_of(library(of))


def library(of: str) -> Path:
    return shipped("libraries", f"keepaway_{of}")


def played(of: str, episodes: int, seed: int, game, *, behavior="Keepaway"):
    """Return the lengths of episodes, s."""
    swarm = trained_keepers(library(of), behavior, game, seed=seed)
    return [one.seconds for one in played_by(swarm, episodes)]


@pytest.mark.long
def test_they_last_longer_than_hand_coded_keepers_against_slow_takers():
    """Five episodes, always the same: each may last minutes, so that a mean tells little."""
    assert sorted(played("predictive", 5, 11, SLOW))[1] >= UT_HAND_S


@pytest.mark.long
def test_looking_ahead_lasts_longer_than_the_parts_it_is_made_of():
    game = {"taker_speed": 1.0}
    parts = played("predictive", 40, 3, game, behavior="PlayBall")
    assert sum(played("predictive", 40, 3, game)) >= 1.5 * sum(parts)


def test_they_last_longer_than_keepers_that_know_distances_only():
    game = {**FULL_SPEED, "taker_policy": "reference"}
    assert sum(played("fullspeed", 6, 3, game)) >= 1.3 * sum(played("predictive", 6, 3, game))


def test_they_play_the_same_in_three_processes_as_in_one(home, tmp_path):
    game = {"taker_speed": 1.0}
    swarm = trained_keepers(library("predictive"), "Keepaway", game, seed=3)
    with temporary_swarm(swarm, tmp_path) as running:
        lengths = [episode.seconds for episode in running.world.play(4, 3)]
    assert lengths == played("predictive", 4, 3, game)
