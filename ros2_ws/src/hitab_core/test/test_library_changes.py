"""What a person does to a library by name: delete, rename, export and import behaviors."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from hitab_core.automaton import Automaton
from hitab_core.domain import Domain
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.library.bundle_file import (
    bundle_file_text,
    read_bundle_file,
    texts_with_parts,
)
from hitab_core.library.loaded_library import LibraryReader
from hitab_core.texts.errors import LibraryError

Teach = Callable[..., Automaton]


@pytest.fixture
def library(
    tmp_path: Path, robot: Domain, approach: Automaton, control: Automaton, keepaway: Automaton
) -> BehaviorLibrary:
    """Return a library of three behaviors, each using the one before."""
    library = BehaviorLibrary(tmp_path / "library", robot)
    for automaton in (approach, control, keepaway):
        library.save(automaton)
    library.load()
    return library


def again(library: BehaviorLibrary) -> BehaviorLibrary:
    """Return another look at the same folder, as another process has it."""
    return BehaviorLibrary(library.folder, library.domain)


def contents(library: BehaviorLibrary) -> dict[str, bytes]:
    files = [path for path in library.folder.rglob("*") if path.is_file()]
    return {str(path.relative_to(library.folder)): path.read_bytes() for path in files}


# -- deleting ---------------------------------------------------------------------------------


def test_what_others_use_is_deleted_only_on_request_and_can_be_restored(
    library: BehaviorLibrary,
) -> None:
    before = contents(library)
    with pytest.raises(LibraryError, match="Control, Keepaway could no longer be used"):
        library.remove("Approach")
    assert contents(library) == before
    assert library.remove("Approach", anyway=True) == ["Control", "Keepaway"]
    assert again(library).load(strict=False) == {}
    library.restore("Approach", 1)
    assert sorted(again(library).load()) == ["Approach", "Control", "Keepaway"]


# -- renaming ---------------------------------------------------------------------------------


def test_a_renamed_behavior_does_the_same_and_so_does_what_uses_it(
    library: BehaviorLibrary, approach: Automaton, control: Automaton
) -> None:
    before = contents(library)
    with pytest.raises(LibraryError, match='"Approach" is used by Control; give --with-users'):
        library.rename("Approach", "ComeNear")
    assert contents(library) == before
    assert library.rename("Approach", "ComeNear", with_users=True) == (["Control"], [])
    other = again(library)
    loaded = other.load()
    assert sorted(loaded) == ["ComeNear", "Control", "Keepaway"]
    assert loaded["ComeNear"].examples == approach.examples
    assert "ComeNear" in loaded["Control"].labels
    assert "Approach" not in loaded["Control"].labels
    values = [[20.0, 10.0, 0.0, 0.0], [0.0, 20.0, 1.0, 0.0]]
    was = control.transitions["Approach"].predict(values)
    assert list(loaded["Control"].transitions["ComeNear"].predict(values)) == [
        "ComeNear" if label == "Approach" else label for label in was
    ]
    assert other.file("Control").uses["ComeNear"] == other.file("ComeNear").checksum
    assert other.file("ComeNear").provenance.note == '"Approach" renamed to "ComeNear"'
    assert other.on_disk.versions("Approach") == [1], "it can still be restored"
    assert other.on_disk.versions("Control") == [1, 2]


def test_behaviors_that_decide_otherwise_once_a_name_differs_are_named(
    library: BehaviorLibrary, teach: Teach
) -> None:
    """Two examples that see the same: which is taken depends on the order of the names."""
    library.save(teach("Aim", [], [("Start", [], "GoFast")]))
    rows = [("Start", [1], "Aim"), ("Aim", [3], "GoFast"), ("Aim", [3], "GoSlow")]
    library.save(teach("Torn", ["DistanceTo(ball)"], rows))
    before = again(library).load()["Torn"]
    users, otherwise = library.rename("Aim", "Zoom", with_users=True)
    after = again(library).load()["Torn"]
    assert users == ["Torn"]
    chosen = [
        str(a.transitions[s].predict([[3.0]])[0]) for a, s in ((before, "Aim"), (after, "Zoom"))
    ]
    assert ("Torn" in otherwise) == (chosen[0].replace("Aim", "Zoom") != chosen[1])


@pytest.mark.parametrize(
    ("new", "complaint"),
    [
        ("Control", "that name is taken"),
        ("GoFast", "that name is taken"),
        ("Patrol", "that name is taken"),
        ("../up", "use up to 100 letters"),
        ("Done", "no behavior can be called"),
    ],
)
def test_a_name_that_is_taken_or_impossible_is_refused(
    library: BehaviorLibrary, new: str, complaint: str
) -> None:
    before = contents(library)
    with pytest.raises(LibraryError, match=complaint):
        library.rename("Keepaway", new)
    assert contents(library) == before


def test_nothing_is_renamed_while_something_is_lost_that_may_use_it(
    library: BehaviorLibrary,
) -> None:
    library.on_disk.file("Keepaway").write_text("nothing")
    with pytest.raises(
        LibraryError, match=r"files that may use it cannot be read.*Keepaway\.hfa\.yaml"
    ):
        library.rename("Approach", "ComeNear", with_users=True)
    with pytest.raises(LibraryError, match='has no behavior "Dance"'):
        library.remove("Dance")


# -- one file ---------------------------------------------------------------------------------


def export(library: BehaviorLibrary, *names: str) -> Path:
    path = library.folder.parent / "behaviors.yaml"
    text = bundle_file_text(texts_with_parts(library.files, names), library.domain.name)
    path.write_text(text, encoding="utf-8")
    return path


def test_an_exported_file_brings_a_behavior_with_all_that_it_is_made_of(
    library: BehaviorLibrary, tmp_path: Path, robot: Domain, teach: Teach
) -> None:
    library.save(teach("Wait", [], [("Start", [], "Stop")]))
    bundle = read_bundle_file(export(library, "Keepaway"))
    assert list(bundle.texts) == ["Approach", "Control", "Keepaway"]
    assert bundle.domain == "small_robot"
    copy = BehaviorLibrary(tmp_path / "copy", robot)
    copy.install(bundle.texts)
    assert copy.texts() == {name: library.texts()[name] for name in bundle.texts}


@pytest.mark.parametrize(
    "text",
    ["plain\n", "no end of line", "tab\t\n", " space first\n", "\r\n", "é \u2028 €\n", "\n\n"],
)
def test_every_text_is_read_as_it_was_written(
    library: BehaviorLibrary, tmp_path: Path, text: str
) -> None:
    """Texts written by other means, such as an editor with other ends of lines."""
    path = tmp_path / "behaviors.yaml"
    path.write_bytes(bundle_file_text({"Approach": text}, "small_robot").encode())
    assert read_bundle_file(path).texts == {"Approach": text}


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("format: 1\ndomain", "format: 2\ndomain", "has format version 2, but this HiTAB reads"),
        ("domain: small", "world: small", "`domain:` is missing"),
        ("files:", "others: 1\nfiles:", "`others:` is not known here"),
        ("digest:", "digest", "not YAML"),
    ],
)
def test_what_is_wrong_with_an_exported_file_is_named(
    library: BehaviorLibrary, old: str, new: str, complaint: str
) -> None:
    path = export(library, "Approach")
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(LibraryError, match=f"behaviors.yaml.*{complaint}"):
        read_bundle_file(path)


def test_every_behavior_of_an_exported_file_is_checked(
    library: BehaviorLibrary, robot: Domain
) -> None:
    texts = {
        name: library.file(name).text.replace("state: Start,", "state: Begin,")
        for name in ("Approach", "Control")
    }
    path = library.folder.parent / "behaviors.yaml"
    path.write_text(bundle_file_text(texts, robot.name))
    with pytest.raises(LibraryError) as refused:
        LibraryReader(robot).read_all(read_bundle_file(path).texts)
    assert "Approach.hfa.yaml:" in str(refused.value)
    assert "Control.hfa.yaml:" in str(refused.value)


def test_an_import_says_what_it_replaces(
    library: BehaviorLibrary, tmp_path: Path, robot: Domain, teach: Teach
) -> None:
    other = BehaviorLibrary(tmp_path / "other", robot)
    other.save(teach("Approach", [], [("Start", [], "Stop")]))
    other.save(teach("Control", [], [("Start", [], "Stop")]))
    other.on_disk.file("Control").write_text("nothing")
    with other.change() as change:
        assert change.install(library.texts()) == ["Approach", "Control", "Keepaway"]
        assert {name: change.replaced(name) for name in sorted(change.changed)} == {
            "Approach": "version 2, replaces version 1 (2 examples)",
            "Control": "version 3, replaces a damaged file, kept as version 2",
            "Keepaway": "",
        }
        change.commit()
    assert sorted(again(other).load()) == ["Approach", "Control", "Keepaway"]


def test_changes_leave_no_file_open(library: BehaviorLibrary, approach: Automaton) -> None:
    before = len(os.listdir("/proc/self/fd"))
    for _ in range(3):
        library.remove("Keepaway")
        library.restore("Keepaway", 1)
        library.save(approach)
        again(library).load()
    assert len(os.listdir("/proc/self/fd")) == before
