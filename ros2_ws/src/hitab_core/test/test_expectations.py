"""A behavior carries expectations, and a change reports the broken ones."""

from dataclasses import replace

import pytest

from hitab_core import BehaviorLibrary, LearningAgent, LibraryError, plain_domain
from hitab_core.library import Expectation

CART = plain_domain("cart", {"Left": [-1.0], "Right": [1.0]}, ["Position"])
FAR = Expectation("far", "Right", {"Position": 9.0}, "Left")


def taught(folder, turns_at: float) -> BehaviorLibrary:
    """Train a cart that goes right, and turns somewhere."""
    agent = LearningAgent(CART, folder).train("Shuttle")
    agent.step([0.0], command="Right")
    agent.step([turns_at], command="Left")
    agent.learn()
    agent.save()
    return agent.agent.library


@pytest.fixture
def library(tmp_path):
    there = taught(tmp_path, 5.0)
    there.expect("Shuttle", [FAR])
    return there


def test_it_is_in_the_file_and_says_what_is_decided_instead(library):
    file = library.file("Shuttle")
    assert file.broken == []
    text = file.text.splitlines()[file.expectations[0].line - 1]
    assert text.strip().startswith("- {name: far, state: Right,")
    again = taught(library.folder, 20.0).file("Shuttle")
    (complaint,) = again.broken
    line = again.expectations[0].line
    assert complaint == (
        f'Shuttle.hfa.yaml:{line}: expectation "far": in Right it decides Right, not Left'
    )
    library.load()
    library.restore("Shuttle", 1)
    assert library.file("Shuttle").broken == []  # of the present ones, which version 1 had not yet
    assert len(library.file("Shuttle").expectations) == 1


def test_without_any_the_file_is_as_before(library):
    assert "optional" not in library.expect("Shuttle", []).text


def test_what_blocks_keeps_the_behavior_as_it_was(library):
    library.expect("Shuttle", [replace(FAR, blocks=True)])
    with pytest.raises(LibraryError, match=r'"Shuttle" cannot be saved: .*"far": in Right'):
        taught(library.folder, 20.0)
    assert library.load()["Shuttle"].transitions["Right"].predict([[9.0]]) == ["Left"]


def test_it_goes_along_with_copies_and_renaming(library, tmp_path):
    other = BehaviorLibrary(tmp_path / "other", CART)
    other.install(library.texts())
    assert [one.name for one in other.file("Shuttle").expectations] == ["far"]
    other.rename("Shuttle", "Commute")
    assert other.file("Commute").broken == []
    assert other.file("Commute").expectations[0].features == {"Position": 9.0}


@pytest.mark.parametrize(
    ("changed", "decides"),
    [
        ({"state": "Stop"}, "nothing, since it has no such state"),
        ({"features": {}}, "by Position, of which the expectation says nothing"),
        ({"state": "Start", "next_state": "Left"}, "Right, not Left"),
        ({"features": {"Position": 1.0, "Color": 2.0}}, "Right, not Left"),
    ],
)
def test_a_decision_that_cannot_be_as_expected_is_reported(library, changed, decides):
    (complaint,) = library.expect("Shuttle", [replace(FAR, **changed)]).broken
    assert f"it decides {decides}" in complaint


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("- {name: far, state: Right, next_state: Left}", "`features:` is missing here"),
        (
            "- {name: a, state: Right, features: {Position: .nan}, next_state: Left}",
            "`Position:` must be",
        ),
        (
            "- {name: a, state: Right, features: {Position: x}, next_state: Left}",
            "must be a number",
        ),
        ("- {name: '', state: Right, features: {}, next_state: Left}", "`name:`"),
        (
            "- {name: a, state: Right, features: {}, next_state: Left, must: 1}",
            "`must:` is not known",
        ),
        ("- far", "must be `key: value` lines"),
        ("far: Left", "must be a list"),
    ],
)
def test_a_wrong_edited_line_is_reported_by_line(library, line, says):
    path = library.on_disk.file("Shuttle")
    lines = path.read_text().splitlines()
    number = library.file("Shuttle").expectations[0].line
    lines[number - 1] = f"    {line}"
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(LibraryError) as refused:
        library.load()
    at = number - 1 if says == "must be a list" else number
    assert any(t.startswith(f"Shuttle.hfa.yaml:{at}:") for t in str(refused.value).splitlines())
    assert says in str(refused.value)


def test_an_edit_of_an_expectation_counts_like_any_other(library):
    path = library.on_disk.file("Shuttle")
    path.write_text(path.read_text().replace("Position: 9.0", "Position: 1.0"))
    library.load()
    assert "it decides Right, not Left" in library.file("Shuttle").broken[0]
