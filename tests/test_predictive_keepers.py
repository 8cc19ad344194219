"""Keepers that look ahead: what their lessons teach, and that it is what is shipped."""

import json
from pathlib import Path

import pytest
from taught import examples_of

from hitab_bringup.bringing_up import temporary_swarm
from hitab_client.lessons.lesson_file import read_lesson
from hitab_client.lessons.lesson_player import LessonPlayer
from hitab_client.shipped import find_file, shipped
from keepaway_world.verbs.evaluation import trained_keepers

LESSONS = ("take_ball", "pass_ball", "play_ball", "keepaway")
UT_HAND_S = 53.5
"""Mean hold time of UT Austin's hand-coded keepers against quarter-speed takers, s."""

LIBRARY = shipped("libraries", "keepaway_predictive")


@pytest.fixture(scope="module")
def learned(home, tmp_path_factory):
    """Return the reports of the lessons, and what keeper_1 has learned."""
    folder = tmp_path_factory.mktemp("predictive")
    swarm = trained_keepers(None, "", {"taker_speed": 0.25}, domain="keepaway_predictive")
    reports = []
    with temporary_swarm(swarm, folder) as running:
        for name in LESSONS:
            lesson = read_lesson(find_file(f"predictive/{name}", "lessons", "lesson"))
            reports.append(LessonPlayer(lesson, running.agents, running.world).play())
        return reports, examples_of(Path(reports[-1].path).parent)


def evaluate(hitab, path, *options):
    done = hitab(
        "keepaway", "evaluate", "-l", str(LIBRARY), "--json", str(path), *options, timeout=100
    )
    assert done.returncode == 0, done.stderr
    return json.loads(path.read_text())


def test_what_is_shipped_is_what_the_lessons_teach(learned):
    assert learned[1] == examples_of(LIBRARY)


@pytest.mark.long
def test_they_last_longer_than_hand_coded_keepers_against_slow_takers(hitab, tmp_path):
    """Five episodes, always the same: each may last minutes, so that a mean tells little."""
    figures = evaluate(
        hitab, tmp_path / "f.json", "--episodes", "5", "--seed", "11", "--pace", "inprocess"
    )
    assert figures["hold_time_s"]["mean"] >= UT_HAND_S
    assert sorted(figures["seconds_of_episodes"])[1] >= UT_HAND_S


@pytest.mark.long
def test_they_last_longer_than_the_papers_words_and_than_their_own_parts(hitab, tmp_path):
    """Against full-speed takers episodes are short: forty of them tell what looking ahead gives.

    Without it they would be as good as the keepers of the paper's words; without the automaton
    that was learned last, as good as keepers that all play the ball.
    """

    def seconds(*options: str) -> float:
        same = ("--episodes", "40", "--seed", "3", "--taker-speed", "1.0", "--pace", "inprocess")
        return evaluate(hitab, tmp_path / "f.json", *same, *options)["hold_time_s"]["mean"]

    whole = seconds()
    assert whole >= 1.2 * seconds("-l", str(shipped("libraries", "keepaway")))
    assert whole >= 1.5 * seconds("--behavior", "PlayBall")


def test_they_play_the_same_in_three_processes_as_in_one(hitab, tmp_path):
    options = ("--episodes", "4", "--seed", "3", "--taker-speed", "1.0")
    lockstep = evaluate(hitab, tmp_path / "l.json", *options)
    inprocess = evaluate(hitab, tmp_path / "i.json", *options, "--pace", "inprocess")
    assert lockstep["missed_deadlines"] == 0
    for key in ("seconds_of_episodes", "passes", "ended", "library_digest"):
        assert lockstep[key] == inprocess[key]
