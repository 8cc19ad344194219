"""What a machine lets others read, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import pytest

from hitab_core import HitabError
from hitab_machines.files.copies import copied_folders
from hitab_machines.files.shared_files import ANSWER_BYTES_MAX, SharedFiles, safe_path


@pytest.fixture
def shared(tmp_path: Path) -> SharedFiles:
    (tmp_path / "run/libraries/ant").mkdir(parents=True)
    (tmp_path / "run/libraries/ant/Dig.yaml").write_text("dig")
    (tmp_path / "secret").write_text("secret")
    (tmp_path / "run/libraries/out").symlink_to(tmp_path)
    return SharedFiles({"libraries": tmp_path / "run/libraries"})


@pytest.mark.parametrize(
    "path",
    ["", "/etc/passwd", "libraries/../../secret", "..", "a//b", "./a", "a/", "a\\b", "a\nb"],
)
def test_odd_paths_are_refused(path: str) -> None:
    with pytest.raises(HitabError, match="is not a path in a shared folder"):
        safe_path(path)


@pytest.mark.parametrize("path", ["secret", "libraries/out/secret", "state/x"])
def test_only_shared_files_are_read(shared: SharedFiles, path: str) -> None:
    with pytest.raises(HitabError, match="is not among the shared files"):
        shared.read([path])


def test_links_are_not_listed_and_files_have_digests(shared: SharedFiles) -> None:
    assert [*shared.digests()] == ["libraries/ant/Dig.yaml"]
    (file,) = shared.read(["libraries/ant/Dig.yaml"])
    assert bytes(file.data) == b"dig"
    assert file.digest == shared.digests()["libraries/ant/Dig.yaml"]


def test_the_token_changes_with_each_file(shared: SharedFiles, tmp_path: Path) -> None:
    before, file = shared.token(), tmp_path / "run/libraries/ant/Dig.yaml"
    assert shared.token() == before
    file.write_text("dug!")
    assert shared.token() != before
    assert len(SharedFiles({}).token()) == 0


def test_an_answer_has_as_many_files_as_fit_and_a_larger_one_is_refused(
    shared: SharedFiles, tmp_path: Path
) -> None:
    folder = tmp_path / "run/libraries/ant"
    for name in "abc":
        (folder / name).write_bytes(bytes(ANSWER_BYTES_MAX // 2 - 1))
    paths = [f"libraries/ant/{name}" for name in "abc"]
    assert [file.path for file in shared.read(paths)] == paths[:2]
    (folder / "c").write_bytes(bytes(ANSWER_BYTES_MAX + 1))
    with pytest.raises(HitabError, match="at most 8,000,000 are copied"):
        shared.read(["libraries/ant/c"])


def test_a_huge_request_is_answered_in_part(shared: SharedFiles) -> None:
    assert len(shared.read(["libraries/ant/Dig.yaml"] * 20_000)) == 500


def test_what_is_left_out_is_not_listed(tmp_path: Path) -> None:
    for name in ("state/world/latest.json", "state/ant_1/agent.db"):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).touch()
    assert [*copied_folders(tmp_path).digests()] == ["state/ant_1/agent.db"]
