"""Recordings, and no other files, are named, renamed and deleted."""

import pytest

from hitab_client.errors import SwarmError
from hitab_client.recording import recordings


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    found = tmp_path / "recordings"
    found.mkdir()
    for name in ("one.mcap", "two.mcap"):
        (found / name).write_bytes(name.encode())
    (tmp_path / "secret.mcap").write_bytes(b"secret")
    return found


def test_a_recording_gets_another_name(folder):
    assert recordings.rename("one.mcap", " goal 1 ") == folder / "goal 1.mcap"
    assert (folder / "goal 1.mcap").read_bytes() == b"one.mcap"
    assert {r.path.name for r in recordings.recordings()} == {"goal 1.mcap", "two.mcap"}
    assert recordings.rename("two.mcap", "two.mcap") == folder / "two.mcap"


@pytest.mark.parametrize("new", ["", "../up", "/etc/passwd", ".hidden", "a/b", "x" * 200])
def test_a_name_that_is_none_is_refused_with_what_is_one(folder, new):
    with pytest.raises(SwarmError, match="letters, digits"):
        recordings.rename("one.mcap", new)
    assert (folder / "one.mcap").exists()


@pytest.mark.parametrize("name", ["three.mcap", "../secret.mcap", "", ".", "one"])
def test_only_a_recording_is_found_renamed_and_deleted(folder, name):
    for act in (recordings.recording, recordings.delete):
        with pytest.raises(SwarmError, match="There is no recording"):
            act(name)
    assert (folder.parent / "secret.mcap").exists()
