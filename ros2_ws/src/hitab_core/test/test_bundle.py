from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from hitab_core.automaton import Automaton
from hitab_core.domain import Domain
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.library.bundle import Bundle, bundle_digest, make_bundle, read_bundle
from hitab_core.library.loaded_library import LibraryReader
from hitab_core.repertoire import Repertoire
from hitab_core.texts.errors import LibraryError

Teach = Callable[..., Automaton]


@pytest.fixture
def library(
    tmp_path: Path,
    robot: Domain,
    approach: Automaton,
    control: Automaton,
    keepaway: Automaton,
    teach: Teach,
) -> BehaviorLibrary:
    library = BehaviorLibrary(tmp_path / "sender", robot)
    other = teach("Other", [], [("Start", [], "Patrol")])
    for automaton in (approach, control, keepaway, other):
        library.save(automaton)
    return library


@pytest.fixture
def repertoire(robot: Domain, library: BehaviorLibrary) -> Repertoire:
    return Repertoire(robot, library.load())


@pytest.fixture
def bundle(library: BehaviorLibrary, repertoire: Repertoire) -> Bundle:
    return make_bundle(library.texts(), repertoire, "Keepaway")


def repacked(*files: tuple[str, str]) -> Bundle:
    return Bundle(files, bundle_digest(files))


def install(bundle: Bundle, receiver: BehaviorLibrary) -> list[str]:
    """Have a library take in a bundle, as the agents that receive one do."""
    read_bundle(bundle, receiver.reader)
    return receiver.install(dict(bundle.files))


def test_a_bundle_holds_all_that_a_behavior_is_made_of_each_after_what_it_uses(
    bundle: Bundle,
) -> None:
    assert [name for name, _ in bundle.files] == ["Approach", "Control", "Keepaway"]
    assert bundle.name == "Keepaway"


def test_a_receiver_has_the_same_files_and_digests_as_the_sender(
    bundle: Bundle, library: BehaviorLibrary, robot: Domain, tmp_path: Path
) -> None:
    receiver = BehaviorLibrary(tmp_path / "receiver", robot)
    assert install(bundle, receiver) == ["Approach", "Control", "Keepaway"]
    library.remove("Other")
    assert receiver.digest == library.digest
    assert receiver.texts() == library.texts()
    assert install(bundle, receiver) == []


def test_what_is_not_there_or_not_saved_cannot_be_sent(
    library: BehaviorLibrary, repertoire: Repertoire, teach: Teach
) -> None:
    with pytest.raises(LibraryError, match='"Dance" cannot be sent: unknown behavior "Dance"'):
        make_bundle(library.texts(), repertoire, "Dance")
    new = teach("New", [], [("Start", [], "Keepaway")])
    repertoire = Repertoire(repertoire.domain, {**repertoire.automata, "New": new})
    with pytest.raises(LibraryError, match=r'"New" has no file .*; save it first'):
        make_bundle(library.texts(), repertoire, "New")


def test_a_bundle_that_changed_on_its_way_is_refused(bundle: Bundle, robot: Domain) -> None:
    (name, text), *rest = bundle.files
    for files in (((name, text + "# more\n"), *rest), tuple(rest), (*rest, (name, text))):
        with pytest.raises(LibraryError, match="it was corrupted in transit; send it again"):
            read_bundle(replace(bundle, files=files), LibraryReader(robot))
    with pytest.raises(LibraryError, match="it was corrupted in transit"):
        read_bundle(replace(bundle, digest="0" * 64), LibraryReader(robot))


def test_the_faults_of_a_bundle_are_reported_and_nothing_is_installed(
    bundle: Bundle, robot: Domain, tmp_path: Path
) -> None:
    approach, control, keepaway = bundle.files
    wrong = {
        "the bundle is empty": repacked(),
        'Control.hfa.yaml:10: state "Approach" uses behavior "Approach", which is neither in': (
            repacked(control, keepaway)
        ),
        "each once and after its own parts": repacked(control, approach, keepaway),
        "each once and after": repacked(approach, approach, control, keepaway),
        "and nothing else": repacked(approach, keepaway, control),
        'Control.hfa.yaml:4: is called "Keepaway"': (
            repacked(approach, ("Control", keepaway[1]), keepaway)
        ),
        "Keepaway.hfa.yaml:3: `features:` is missing here": (
            repacked(approach, control, ("Keepaway", keepaway[1].partition("features:")[0]))
        ),
    }
    receiver = BehaviorLibrary(tmp_path / "receiver", robot)
    for complaint, sent in wrong.items():
        with pytest.raises(LibraryError) as refused:
            install(sent, receiver)
        assert complaint in str(refused.value)
    assert receiver.load() == {}


def test_a_bundle_that_does_not_fit_the_receivers_own_behaviors_changes_nothing(
    bundle: Bundle, robot: Domain, tmp_path: Path, teach: Teach
) -> None:
    receiver = BehaviorLibrary(tmp_path / "receiver", robot)
    receiver.save(
        teach("Approach", ["DistanceTo(A)"], [("Start", [3], "GoSlow")], parameters=["A"])
    )
    receiver.save(teach("Mine", [], [("Start", [], "Approach(ball)")]))
    before = receiver.digest
    with pytest.raises(LibraryError, match=r"Mine\.hfa\.yaml:10: .* takes 0 target"):
        install(bundle, receiver)
    receiver.load()
    assert receiver.digest == before
    assert sorted(receiver.files) == ["Approach", "Mine"]
