from __future__ import annotations

import errno
import itertools
import os
import shutil
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from faulty_disk import FaultyDisk, Killed

from hitab_core.automaton import Automaton
from hitab_core.domain import Domain
from hitab_core.example import ExampleKind
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.library.commit import CHANGE, commit, files_in
from hitab_core.library.differences import difference
from hitab_core.library.durable_files import locked
from hitab_core.repertoire import Repertoire
from hitab_core.texts.errors import LibraryError
from hitab_core.texts.remedies import Fix

Teach = Callable[..., Automaton]


@pytest.fixture
def library(
    tmp_path: Path, robot: Domain, approach: Automaton, control: Automaton, keepaway: Automaton
) -> BehaviorLibrary:
    """Return a library of three behaviors, each using the one before."""
    library = BehaviorLibrary(tmp_path / "library", robot, clock=lambda: "2012-06-18T09:30:00Z")
    for automaton in (approach, control, keepaway):
        library.save(automaton, agent="keeper_1")
    library.load()
    return library


def again(library: BehaviorLibrary) -> BehaviorLibrary:
    """Return another look at the same folder, as another process has it."""
    return BehaviorLibrary(library.folder, library.domain)


def snapshot(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_what_was_saved_is_there_for_others(
    library: BehaviorLibrary, robot: Domain, keepaway: Automaton
) -> None:
    other = again(library)
    trained = other.load()
    assert sorted(trained) == sorted(other.files) == ["Approach", "Control", "Keepaway"]
    assert trained["Keepaway"].examples == keepaway.examples
    assert other.digest == library.digest
    assert Repertoire(robot, trained).needed_by("Keepaway") == ["Approach", "Control", "Keepaway"]


def test_the_same_training_has_the_same_digest_whenever_and_by_whom_it_was_saved(
    tmp_path: Path, robot: Domain, approach: Automaton, control: Automaton
) -> None:
    one, other = (
        BehaviorLibrary(tmp_path / name, robot, clock=lambda time=time: time)
        for name, time in (("one", "2012-06-18T09:30:00Z"), ("other", "2013-01-01T00:00:00Z"))
    )
    for library, agent in ((one, "keeper_1"), (other, "keeper_2")):
        library.save(approach, agent=agent)
    other.save(approach, note="once more")
    one.save(control)
    renumbered = [
        replace(
            example,
            number=50 - i,
            command=example.command + 3,
            cycle=0,
            kind=ExampleKind.DEFAULT if example.is_default else ExampleKind.CORRECTION,
        )
        for i, example in enumerate(reversed(control.examples))
    ]
    other.save(replace(control, examples=tuple(renumbered), description="said otherwise"))
    assert one.file("Approach").checksum != other.file("Approach").checksum
    assert one.file("Control").checksum != other.file("Control").checksum
    assert one.digest == other.digest == again(other).digest


@pytest.mark.parametrize(
    ("features", "rows", "options"),
    [
        (["DistanceTo(ball)"], [("Start", [9], "GoFast"), ("GoFast", [2.5], "Stop")], {}),
        (["DistanceTo(ball)"], [("Start", [8], "GoFast"), ("GoFast", [2], "Stop")], {}),
        (["DistanceTo(goal)"], [("Start", [9], "GoFast"), ("GoFast", [2], "Stop")], {}),
        (["DistanceTo(ball)"], [("Start", [9], "GoFast"), ("GoFast", [2], "GoSlow")], {}),
        (
            ["DistanceTo(ball)"],
            [("Start", [9], "GoFast"), ("GoFast", [2], "Stop")],
            {"defaults": False},
        ),
        (
            ["DistanceTo(ball)"],
            [("Start", [9], "GoFast"), ("GoFast", [2], "Stop")],
            {"classifier": "tree(prune=True)"},
        ),
    ],
    ids=["threshold", "example", "feature", "state", "defaults", "classifier"],
)
def test_what_was_learned_otherwise_has_another_digest(
    tmp_path: Path,
    robot: Domain,
    teach: Teach,
    features: list[str],
    rows: list[tuple[str, list[float], str]],
    options: dict[str, object],
) -> None:
    one, other = (BehaviorLibrary(tmp_path / name, robot) for name in ("one", "other"))
    usual = [("Start", [9], "GoFast"), ("GoFast", [2], "Stop")]
    one.save(teach("A", ["DistanceTo(ball)"], usual))
    classifier = str(options.get("classifier", "tree"))
    other.save(teach("A", features, rows, **options), classifier=classifier)
    assert one.digest != other.digest


def test_a_file_tells_what_it_was_made_of_and_where_it_comes_from(
    library: BehaviorLibrary,
) -> None:
    file = library.file("Control")
    assert file.uses == {
        "Approach": library.file("Approach").checksum,
        "GoTo": "basic",
        "Kick": "basic",
    }
    assert file.provenance.agent == "keeper_1"
    assert file.provenance.created == "2012-06-18T09:30:00Z"


def test_earlier_versions_are_kept_and_can_be_restored(
    library: BehaviorLibrary, approach: Automaton, teach: Teach
) -> None:
    first = library.file("Approach").checksum
    library.save(teach("Approach", ["DistanceTo(ball)"], [("Start", [3], "GoSlow")]))
    second = library.file("Approach")
    assert library.on_disk.versions("Approach") == [1, 2]
    assert second.provenance.version == 2
    assert second.provenance.earlier == first
    assert library.on_disk.version("Approach", 1).checksum == first
    library.restore("Approach", 1)
    third = again(library).file("Approach")
    assert third.automaton.examples == approach.examples
    assert (third.provenance.version, third.provenance.note) == (3, "version 1 restored")
    with pytest.raises(LibraryError, match=r'no version 7 of "Approach" \(known: 1, 2, 3\)'):
        library.restore("Approach", 7)


def test_the_difference_between_versions_names_examples_rules_states_and_features(
    library: BehaviorLibrary, teach: Teach
) -> None:
    library.save(
        teach(
            "Approach",
            ["DistanceTo(ball)", "BallIsKickable"],
            [("Start", [20.25, 0], "GoFast"), ("GoFast", [9, 1], "Kick")],
        )
    )
    first, second = (library.on_disk.version("Approach", number) for number in (1, 2))
    found = difference(first, second, library.domain)
    assert found.startswith(
        "- state GoSlow\n- state Stop\n+ state Kick\n+ feature BallIsKickable\nrules:\n"
    )
    assert "\n+ GoFast: if BallIsKickable: Kick\n" in found
    assert "\n- Stop -> GoFast (demonstrated) DistanceTo(ball) = 7.1 m\n" in found
    control = library.file("Control")
    assert difference(control, control, library.domain) == "no difference"


def test_a_missing_behavior_is_named_with_the_line_of_the_state(
    library: BehaviorLibrary,
) -> None:
    (library.folder / "Approach.hfa.yaml").unlink()
    shutil.rmtree(library.folder / ".versions" / "Approach")
    with pytest.raises(LibraryError) as refused:
        again(library).load()
    line = library.file("Control").state_lines[0]
    assert str(refused.value).splitlines() == [
        f'Control.hfa.yaml:{line}: state "Approach" uses behavior "Approach", which is neither in '
        'the library (known: Control, Keepaway) nor a behavior of domain "small_robot" (known: '
        "GoFast, GoSlow, GoTo, Kick, Patrol, Stop); put Approach.hfa.yaml into the folder, or "
        "take the state out",
        'Keepaway.hfa.yaml:10: state "Control" uses behavior "Control", which cannot be used; '
        "bring that back first",
    ]


def test_a_behavior_that_was_deleted_is_brought_back_and_what_uses_it_is_not_blamed(
    library: BehaviorLibrary,
) -> None:
    library.remove("Approach", anyway=True)
    with pytest.raises(LibraryError) as refused:
        again(library).load()
    reason = 'uses behavior "Approach", which was deleted; bring its version 1 back'
    assert reason in str(refused.value)
    losses = again(library).loaded(strict=False).losses
    (fault,) = losses.faults
    assert reason in fault
    restored, given_up = losses.remedies["Control"]
    assert restored == Fix.RESTORE(behavior="Approach", version=1, folder=library.folder)
    assert given_up.code is Fix.DELETE


def test_what_is_wrong_in_several_files_is_reported_together_and_the_others_can_be_used(
    library: BehaviorLibrary, teach: Teach
) -> None:
    library.save(teach("Wait", [], [("Start", [], "Stop")]))
    for name, old, new in (("Approach", "GoFast", "GoFsat"), ("Control", "mat: 3", "mat: 9")):
        path = library.folder / f"{name}.hfa.yaml"
        path.write_text(path.read_text().replace(old, new))
    other = again(library)
    with pytest.raises(LibraryError) as refused:
        other.load()
    assert "Approach.hfa.yaml:" in str(refused.value)
    assert "Control.hfa.yaml:3: has format version 9" in str(refused.value)
    assert list(other.load(strict=False)) == ["Wait"]
    assert sorted(other.problems) == ["Approach", "Control", "Keepaway"]
    assert other.digest == other.digest != library.digest


def test_an_automaton_that_uses_itself_is_refused_on_saving_and_on_loading(
    library: BehaviorLibrary, teach: Teach
) -> None:
    before = snapshot(library.folder)
    with pytest.raises(LibraryError, match=r"Loop -> Loop\); a behavior cannot use itself"):
        library.save(teach("Loop", [], [("Start", [], "Loop")]))
    with pytest.raises(LibraryError, match="Approach -> Keepaway -> Control -> Approach"):
        library.save(teach("Approach", [], [("Start", [], "Keepaway")]))
    assert snapshot(library.folder) == before
    looping = library.folder.parent / "looping"
    one, two = (
        BehaviorLibrary(looping / "1", library.domain),
        BehaviorLibrary(looping / "2", library.domain),
    )
    one.save(teach("One", [], [("Start", [], "Stop")]))
    one.save(teach("Two", [], [("Start", [], "One")]))
    two.save(teach("Two", [], [("Start", [], "Stop")]))
    two.save(teach("One", [], [("Start", [], "Two")]))
    (one.folder / "One.hfa.yaml").write_bytes((two.folder / "One.hfa.yaml").read_bytes())
    with pytest.raises(LibraryError) as refused:
        again(one).load()
    assert "One.hfa.yaml:10: " in str(refused.value)
    assert "recursive (One -> Two -> One)" in str(refused.value)


def test_a_name_cannot_lead_out_of_the_folder(library: BehaviorLibrary) -> None:
    with pytest.raises(LibraryError, match="no behavior can be called"):
        library.install({"../Approach": library.texts()["Approach"]})
    with pytest.raises(LibraryError, match="no behavior can be called"):
        library.on_disk.versions("../../library")


def test_transition_functions_that_are_not_what_the_examples_teach_are_refused(
    library: BehaviorLibrary, approach: Automaton, teach: Teach
) -> None:
    other = teach("Approach", ["DistanceTo(ball)"], [("Start", [3], "GoSlow")])
    mixed = Automaton(
        "Mixed", approach.states, approach.features, other.transitions, (), approach.examples
    )
    with pytest.raises(LibraryError, match='"Mixed" cannot be saved:\nMixed'):
        library.save(mixed)


def test_an_edited_file_is_what_it_says_once_it_is_right(library: BehaviorLibrary) -> None:
    path = library.folder / "Approach.hfa.yaml"
    saved = path.read_text()
    path.write_text(saved.replace("4.5", "four"))
    with pytest.raises(LibraryError, match="must be a number"):
        again(library).load()
    path.write_text(saved.replace("4.5", "2.5"))
    edited = again(library).file("Approach")
    assert edited.automaton.examples[2].features == (2.5,)
    tree, whole = edited.edits
    assert 'what is learned for state "GoFast" differs from what was saved' in tree
    assert "the file was edited or damaged after it was saved" in whole
    assert again(library).file("Control").edits == ()
    library.restore("Approach", 1)
    assert again(library).file("Approach").edits == ()
    assert library.on_disk.version("Approach", 2).checksum == edited.checksum, "it is kept"


def test_a_file_changed_by_other_means_is_kept_before_it_is_replaced(
    library: BehaviorLibrary, approach: Automaton
) -> None:
    path = library.folder / "Approach.hfa.yaml"
    path.write_bytes(b"\xff something of value")
    with pytest.raises(LibraryError, match="it would take the place of a lost behavior"):
        again(library).save(approach)
    again(library).restore("Approach", 1)
    assert library.on_disk.versions("Approach") == [1, 2, 3]
    kept = library.folder / ".versions/Approach/0002.hfa.yaml"
    assert kept.read_bytes() == b"\xff something of value"
    assert again(library).load().keys() == {"Approach", "Control", "Keepaway"}


def test_installing_is_all_or_nothing(
    library: BehaviorLibrary, tmp_path: Path, robot: Domain
) -> None:
    other = BehaviorLibrary(tmp_path / "other", robot)
    texts = library.texts()
    broken = {**texts, "Control": texts["Control"].replace("Kick", "Kcik")}
    with pytest.raises(LibraryError):
        other.install(broken)
    with pytest.raises(LibraryError, match="cannot be added"):
        other.install({"Control": texts["Control"]})
    assert snapshot(tmp_path / "other") == {}
    assert other.install(texts) == ["Approach", "Control", "Keepaway"]
    assert other.install(texts) == []
    assert other.on_disk.versions("Control") == [1]
    noted = {**texts, "Control": texts["Control"] + "# well done\n"}
    assert other.install(noted) == ["Control"]
    assert again(other).texts() == noted
    assert other.on_disk.versions("Control") == [1, 2]


@pytest.mark.parametrize("how", ["once", "full", "killed"])
def test_a_change_of_several_behaviors_is_made_or_not_whichever_operation_fails(
    library: BehaviorLibrary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    """Renaming writes two files, keeps their versions and removes one file."""
    before = again(library).load()
    for number in itertools.count(1):
        copied = shutil.copytree(library.folder, tmp_path / str(number) / "library")
        copy = BehaviorLibrary(copied, library.domain)
        answer, why = "made", str(copied)
        with monkeypatch.context() as patch:
            disk = FaultyDisk(patch, copied.parent, number, how)
            try:
                copy.rename("Approach", "ComeNear", with_users=True)
            except LibraryError as error:
                answer, why = "refused", str(error)
            except Killed:
                answer = "killed"
        assert str(copied) in why, "it names the place"
        made = "ComeNear" in again(copy).load()
        assert made == (answer == "made") or answer == "killed"
        assert again(copy).load().keys() == (
            {"ComeNear", "Control", "Keepaway"} if made else before.keys()
        )
        assert again(copy).on_disk.versions("Control") == ([1, 2] if made else [1])
        again(copy).remove("Keepaway")  # the next to write removes what is left
        assert not [path for path in copied.rglob(".*") if path.name != ".versions"]
        if not disk.failed:
            assert answer == "made"
            break
    assert number > 10


def test_a_change_that_cannot_be_put_in_place_counts_for_every_reader(
    library: BehaviorLibrary, teach: Teach, monkeypatch: pytest.MonkeyPatch
) -> None:
    library.save(teach("Wait", [], [("Start", [], "Stop")]))

    def read_only(*args: object) -> None:
        raise OSError(errno.EROFS, "read-only")

    with monkeypatch.context() as patch:
        patch.setattr("hitab_core.library.commit.os.replace", read_only)
        library.save(teach("New", [], [("Start", [], "GoSlow")]))
        assert (library.folder / CHANGE).is_dir()
        assert "New" in again(library).load()
        assert again(library).on_disk.version("New", 1).automaton.labels == ("GoSlow",)
        with pytest.raises(LibraryError, match="the disk is read-only; copy it to a writable one"):
            library.remove("Wait")
    assert "New" in again(library).load()
    assert (library.folder / "New.hfa.yaml").exists()
    assert not (library.folder / CHANGE).exists()


def test_a_failed_save_changes_nothing(
    library: BehaviorLibrary, approach: Automaton, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = snapshot(library.folder)

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("hitab_core.library.durable_files.os.fsync", full)
        with pytest.raises(LibraryError, match="No space left on device; make room on the disk"):
            library.save(approach)
    assert snapshot(library.folder) == before


def test_a_folder_that_may_not_be_written_can_be_read_and_is_named(
    library: BehaviorLibrary, approach: Automaton, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = os.open

    def read_only(path: Path, flags: int, mode: int = 0o777) -> int:
        if flags & (os.O_WRONLY | os.O_RDWR):
            raise PermissionError(13, "Permission denied")
        return opened(path, flags, mode)

    monkeypatch.setattr("hitab_core.library.durable_files.os.open", read_only)
    assert again(library).load()
    with pytest.raises(LibraryError, match="Permission denied; check its permissions"):
        library.save(approach)


WRITER = """
import sys, time
from pathlib import Path
from hitab_core.library.durable_files import locked
from hitab_core.library.commit import commit
folder, texts = Path(sys.argv[1]), [Path(p).read_bytes() for p in sys.argv[2:]]
print("ready", flush=True)
for i in range(100_000):
    with locked(folder, alone=True):
        commit(folder, {n: texts[i % 2] for n in ("One.txt", "Two.txt", ".versions/A/1.txt")})
    time.sleep(0.003)  # others get their turn
"""


def test_readers_never_see_half_of_what_several_writers_write_even_if_they_are_killed(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    texts = {tmp_path / name: name.encode() * 50_000 for name in "abcd"}
    for path, text in texts.items():
        path.write_bytes(text)
    paths = [str(path) for path in texts]
    writers = [
        subprocess.Popen(
            [sys.executable, "-c", WRITER, str(folder), *mine],
            stdout=subprocess.PIPE,
            text=True,
        )
        for mine in (paths[:2], paths[2:])
    ]
    try:
        for writer in writers:
            assert writer.stdout is not None
            assert writer.stdout.readline() == "ready\n"
        seen: set[bytes] = set()
        deadline = time.monotonic() + 20
        while len(seen - {b""}) < 3 and time.monotonic() < deadline:
            seen.add(read_together(folder))
        writers[0].send_signal(signal.SIGKILL)
        writers[0].wait(10)
        assert read_together(folder) in texts.values()
        writers[1].send_signal(signal.SIGKILL)
        writers[1].wait(10)
        with locked(folder, alone=True):
            commit(folder, {})
        assert read_together(folder) in texts.values()
        assert not [path for path in folder.rglob("*") if ".tmp" in path.name]
        assert seen - {b""} <= set(texts.values())
        assert len(seen - {b""}) >= 2
    finally:
        for writer in writers:
            writer.kill()
            writer.wait(10)
            assert writer.stdout is not None
            writer.stdout.close()


def read_together(folder: Path) -> bytes:
    """Return what all files hold, as a reader of a library sees them."""
    from hitab_core.library.commit import held

    with held(folder, alone=False):
        top, inside = files_in(folder), files_in(folder, ".versions/A")
        found = {
            path.read_bytes() if path is not None else b""
            for path in (top.get("One.txt"), top.get("Two.txt"), inside.get("1.txt"))
        }
    assert len(found) == 1
    return found.pop()


SAVER = textwrap.dedent(
    """
    import sys
    from hitab_core.library.behavior_library import BehaviorLibrary
    from hitab_core.domain import BasicBehavior, Domain
    from hitab_core.automaton import Automaton
    from hitab_core.example import Example
    from hitab_core.learning.transition_learning import learn_transitions
    from hitab_core.term import Term

    robot = Domain.of("r", "1", None, behaviors=[BasicBehavior("Stop")], features=[])
    library = BehaviorLibrary(sys.argv[1], robot)
    example = (Example("Start", (), "Stop", number=1),)
    for i in range(int(sys.argv[3])):
        automaton = Automaton(
            "Rest", (Term("Stop"),), (), learn_transitions(example, ()), (), example
        )
        library.save(automaton, agent=sys.argv[2])
    """
)


def test_two_processes_that_save_the_same_behavior_lose_no_version(tmp_path: Path) -> None:
    folder = tmp_path / "library"
    savers = [
        subprocess.Popen([sys.executable, "-c", SAVER, str(folder), agent, "8"])
        for agent in ("keeper_1", "keeper_2")
    ]
    assert [saver.wait(60) for saver in savers] == [0, 0]
    from hitab_core.domain import BasicBehavior

    robot = Domain.of("r", "1", lambda name: None, behaviors=[BasicBehavior("Stop")], features=[])
    library = BehaviorLibrary(folder, robot)
    assert library.on_disk.versions("Rest") == list(range(1, 17))
    files = [
        library.on_disk.version("Rest", number) for number in library.on_disk.versions("Rest")
    ]
    assert [file.provenance.earlier for file in files[1:]] == [f.checksum for f in files[:-1]]
    assert {file.provenance.agent for file in files} == {"keeper_1", "keeper_2"}
