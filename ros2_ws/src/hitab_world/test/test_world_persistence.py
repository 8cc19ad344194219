"""A world goes on with what it was asked to, however soon its process ends afterwards."""

import json
import time

import pytest
from hitab_msgs.msg import WorldStatus

from hitab_world.control import Control
from hitab_world.course import Course
from hitab_world.lockstep import RoundAnswers
from hitab_world.settings import WorldSettings
from hitab_world.world_memory import LATEST
from hitab_world.world_persistence import WorldPersistence


class Pond:
    """A world that takes its time to say how it is."""

    cycle = 0

    def snapshot(self):
        time.sleep(0.02)
        return {"ducks": 1}


@pytest.fixture
def course():
    control = Control(WorldStatus.LOCKSTEP, 1.0, paused=True)
    return Course(Pond(), control, RoundAnswers((), lambda _: True))


def persistence_of(course, folder, warned):
    settings = WorldSettings(swarm="pond-1", state_dir=str(folder), snapshot_period=60.0)
    return WorldPersistence("world", course, settings, warned.append)


def ask_for(course, episodes):
    course.control.episodes_left = episodes
    course.change()


def test_a_request_is_saved_before_it_is_acknowledged_also_right_after_another(course, tmp_path):
    """It was saved once the world had its leisure: a world killed before then stood still."""
    warned = []
    persistence = persistence_of(course, tmp_path, warned)
    persistence.save_if_due()
    for episodes in range(1, 6):
        ask_for(course, episodes)
        persistence.save_now()
        saved = json.loads((tmp_path / "world" / LATEST).read_bytes())
        assert saved["control"]["episodes_left"] == episodes
    persistence.close()
    assert warned == []


def test_a_request_that_changes_nothing_saves_nothing(course, tmp_path):
    persistence = persistence_of(course, tmp_path, [])
    persistence.save_now()
    assert not (tmp_path / "world").exists()


def test_what_cannot_be_saved_holds_up_no_request(course, tmp_path):
    (tmp_path / "world").write_text("no folder")
    warned = []
    persistence = persistence_of(course, tmp_path, warned)
    for episodes in (1, 2):
        ask_for(course, episodes)
        persistence.save_now()
    persistence.close()
    persistence.save_now()
    (told,) = warned
    assert "a restart would not resume the world's latest state" in told
