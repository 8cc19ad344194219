"""What a world goes on from after a restart of its process."""

import pytest

from hitab_core.errors import HitabError
from hitab_world import world_memory
from hitab_world.world_memory import LATEST, WorldMemory

RUN, NEXT_RUN = "keepaway-1", "keepaway-2"


@pytest.fixture
def warned():
    return []


def make(folder, warned, swarm=RUN):
    return WorldMemory(folder / "world", swarm, warned.append)


def test_the_last_state_that_was_kept_is_there_for_the_same_swarm_only(tmp_path, warned):
    memory = make(tmp_path, warned)
    for cycle in range(200):
        memory.keep({"cycle": cycle})
    memory.close()
    assert make(tmp_path, warned).latest()["cycle"] == 199
    assert make(tmp_path, warned, NEXT_RUN).latest() is None
    assert warned == []
    assert [path.name for path in (tmp_path / "world").iterdir()] == []


def test_saved_snapshots_are_there_under_any_name_until_they_are_deleted(tmp_path, warned):
    memory = make(tmp_path, warned)
    for name in ("corner", "../x", "a" * 300, ""):
        memory.save(name, {"of": name})
    memory.delete("corner")
    found = make(tmp_path, warned).named()
    assert found == {name: {"of": name} for name in ("../x", "a" * 300, "")}
    assert make(tmp_path, warned, NEXT_RUN).named() == found, "somebody may have saved them"


@pytest.mark.parametrize("damaged", [b"", b"\0" * 50, b'{"swarm"', b"[]", b"\xff", b"[" * 10**5])
def test_damaged_files_are_ignored_with_a_warning_that_names_them(tmp_path, warned, damaged):
    memory = make(tmp_path, warned)
    memory.save("corner", {})
    (saved,) = (tmp_path / "world").iterdir()
    latest = tmp_path / "world" / LATEST
    for file in (saved, latest):
        file.write_bytes(damaged)
    memory = make(tmp_path, warned)
    assert memory.latest() is None
    assert memory.named() == {}
    assert [str(file) in text for file, text in zip((latest, saved), warned, strict=True)] == [
        True,
        True,
    ]


def test_a_state_that_is_too_large_is_refused(tmp_path, warned, monkeypatch):
    monkeypatch.setattr(world_memory, "BYTES_MAX", 1000)
    with pytest.raises(HitabError, match="1000"):
        make(tmp_path, warned).keep({"text": "x" * 1000})


def test_a_folder_that_cannot_be_written_is_told_once(tmp_path, warned):
    (tmp_path / "world").write_text("not a folder")
    memory = make(tmp_path, warned)
    for cycle in range(3):
        memory.keep({"cycle": cycle})
    memory.close()
    assert len(warned) == 1
    with pytest.raises(HitabError, match="cannot write"):
        make(tmp_path, warned).save("corner", {})
