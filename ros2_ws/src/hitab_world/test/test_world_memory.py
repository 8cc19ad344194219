"""What a world goes on from after a restart of its process, however soon it ends."""

import errno
import json
from pathlib import Path

import pytest
from hitab_msgs.msg import WorldStatus

from hitab_core.texts.errors import HitabError
from hitab_world.node.settings import WorldSettings
from hitab_world.simulating.control import Control
from hitab_world.simulating.lockstep import RoundAnswers
from hitab_world.simulating.run_state import RunState
from hitab_world.simulating.world_memory import LATEST_FILE, WorldMemory

RUN, NEXT_RUN = "pond-1", "pond-2"


class Pond:
    cycle = 0
    ducks = 0

    def snapshot(self):
        return {"ducks": self.ducks}

    def restore(self, snapshot):
        self.ducks = snapshot["ducks"]


@pytest.fixture
def memory_of(tmp_path):
    """Make what a new process of a swarm's world remembers; its warnings are in ``warned``."""

    def make(swarm=RUN, *, paused=True):
        control = Control(WorldStatus.LOCKSTEP, 1.0, paused)
        made.run_state = RunState(Pond(), control, RoundAnswers((), lambda _: True))
        settings = WorldSettings(swarm=swarm, state_dir=str(tmp_path), snapshot_period=60.0)
        return WorldMemory(
            "world", made.run_state, settings, made.warned.append, made.unsaved.append
        )

    made = make
    made.warned, made.unsaved = [], []
    return make


def ask_for(memory_of, episodes):
    memory_of.run_state.control.episodes_left = memory_of.run_state.world.ducks = episodes
    memory_of.run_state.change()


def test_a_request_is_saved_before_it_is_acknowledged_also_right_after_another(
    memory_of, tmp_path
):
    """It was saved once the world had its leisure: a world killed before then stood still."""
    memory = memory_of()
    memory.save_now()
    assert not (tmp_path / "world").exists(), "nothing has changed"
    for episodes in range(1, 6):
        ask_for(memory_of, episodes)
        memory.save_now()
        saved = json.loads((tmp_path / "world" / LATEST_FILE).read_bytes())
        assert saved["control"]["episodes_left"] == episodes
    assert set(memory_of.unsaved) == {""}


def test_the_last_state_is_there_for_the_same_swarm_only(memory_of):
    memory = memory_of()
    ask_for(memory_of, 7)
    memory.save_latest()
    assert not memory_of(NEXT_RUN).restore()
    assert memory_of().restore()
    run_state = memory_of.run_state
    assert (run_state.world.ducks, run_state.control.episodes_left) == (7, 7)


@pytest.mark.parametrize("paused", [True, False])
def test_only_a_pause_outlasts_the_end_of_a_swarm(memory_of, paused):
    memory = memory_of(paused=paused)
    ask_for(memory_of, 7)
    memory.save_latest()
    assert not memory_of(NEXT_RUN, paused=False).restore()
    run_state = memory_of.run_state
    assert (run_state.control.paused, run_state.control.episodes_left) == (paused, 0)


def test_saved_snapshots_are_there_under_any_name_until_they_are_deleted(memory_of):
    memory = memory_of()
    for name in ("corner", "../x", "a" * 300, ""):
        memory.save(name, {"of": name})
    memory.delete("corner")
    for swarm in (RUN, NEXT_RUN):
        again = memory_of(swarm)
        again.restore()
        assert again.named == {name: {"of": name} for name in ("../x", "a" * 300, "")}


@pytest.mark.parametrize("damaged", [b"", b"\0" * 50, b"[]", b"{}", b"\xff", b"[" * 10**5])
def test_damaged_files_are_ignored_with_a_warning_that_names_them(memory_of, tmp_path, damaged):
    memory_of().save("corner", {})
    (saved,) = (tmp_path / "world").iterdir()
    latest = tmp_path / "world" / LATEST_FILE
    for file in (saved, latest):
        file.write_bytes(damaged)
    memory = memory_of()
    assert not memory.restore()
    assert memory.named == {}
    assert [
        str(file) in text for file, text in zip((saved, latest), memory_of.warned, strict=True)
    ]


def test_a_state_that_cannot_be_saved_is_a_fault_until_it_can_be(memory_of, monkeypatch):
    memory = memory_of()
    memory_of.run_state.world.cycle = 466
    memory.save_latest()

    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as on_disk:
        on_disk.setattr(Path, "write_text", full)
        memory_of.run_state.world.cycle = 543
        memory.save_latest()
    assert "(No space left on device)" in memory_of.unsaved[-1]
    assert "if its process restarts, it will go back to cycle 466" in memory_of.unsaved[-1]
    memory.save_latest()
    assert memory_of.unsaved[-1] == "", "it is saved though nothing has changed"


def test_what_cannot_be_saved_is_told_and_holds_up_no_request(memory_of, tmp_path):
    (tmp_path / "world").write_text("not a folder")
    memory = memory_of()
    for episodes in (1, 2):
        ask_for(memory_of, episodes)
        memory.save_now()
    (told,) = {*memory_of.unsaved}
    assert "its state cannot be saved" in told
    with pytest.raises(HitabError, match="cannot write"):
        memory.save("corner", {})
