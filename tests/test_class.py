"""A class: the steps of the page solve its exercises over topics, and nothing else does."""

import json
import os
import shlex

import pytest
from pages import Reader, steps_of

from hitab_class.exercises import read_exercise
from hitab_client import LessonError
from hitab_client.runs.shipped import shipped_folders, shipped_names

EXERCISES = {"chase", "approach", "correction", "team", "order", "squad"}


@pytest.fixture
def student(apart, monkeypatch):
    """Return what types a command that must succeed, and returns all that it printed."""
    (checkout := apart / "checkout").mkdir()
    monkeypatch.setenv("HITAB_HOME", str(apart / "ann"))
    reader = Reader(checkout, {**os.environ, "COLUMNS": "200"})

    def types(command: str, status: int = 0) -> str:
        did, out, err = reader._run(command)
        assert did == status, f"{command}\n{out}\n{err}"
        return out + err

    return types


def failed(student) -> dict[str, list[str]]:
    """Return what each exercise misses."""
    student("hitab grade --json grades.json", 1)
    (grades,) = [json.loads(student("cat grades.json"))]
    return {name: [one["missing"] for one in found] for name, found in grades.items()}


def test_who_has_done_nothing_is_told_what_to_do(student):
    missing = failed(student)
    assert set(missing) == EXERCISES == set(shipped_names("exercises"))
    for texts in missing.values():
        assert all("was not up yet" in text and "start it" in text for text in texts)
    graded = student("hitab grade chase -l keepaway", 1)
    assert 'keeper_1 has saved no "Chase"' in graded
    assert "train and save it" in graded
    approach = student("hitab grade approach -l keepaway")
    assert "FAIL" not in approach
    assert "approach: 5 of 5 requirements" in approach


@pytest.mark.long
def test_the_steps_of_the_page_solve_the_exercises(student):
    steps = [step.command for step in steps_of("docs/class.md")]
    steps = [step for step in steps if step.startswith("hitab ")]
    end = steps.index("hitab down")
    steps, down, last = steps[:end], steps[end], steps[end + 1 :]
    first = next(i for i, step in enumerate(steps) if step.startswith("hitab lesson run"))
    for step in steps[:first]:
        student(step)
    assert "chase: 4 of 4" in student("hitab grade chase")
    assert "it has 0 corrections" in student("hitab grade correction", 1)
    for step in steps[first:]:
        student(step)
    graded = student("hitab grade chase approach correction team")
    assert "FAIL" not in graded

    # What breaks what is expected is reported by everything that learns it again.
    student("hitab train keeper_1 Chase --resume")
    student("hitab examples delete keeper_1 6 7")
    broken = 'expectation "expectation_1": in GoFast it decides GoFast, not TurnToBall'
    assert broken in student("hitab test keeper_1")
    assert broken in student("hitab save keeper_1")
    assert broken in student("hitab library reload keeper_1")
    assert broken in student("hitab distribute keeper_1 Chase --to keeper_2")
    assert broken in student("hitab library show Chase --agent keeper_1")
    missing = failed(student)
    assert broken in missing["correction"][0]
    assert "keeper_3 learned otherwise" in missing["team"][1]
    assert missing["approach"] == [""] * 5
    student(down)

    for step in last:
        student(step)
    assert "squad: 4 of 4" in student("hitab grade squad")


def test_the_page_on_commanders_solves_the_last_exercise(student):
    steps = [step.command for step in steps_of("docs/commanders.md")]
    for step in steps[: steps.index("hitab order captain Coach")]:
        student(step)
    student("hitab down")
    assert "order: 3 of 3" in student("hitab grade order")


@pytest.mark.parametrize("folder", shipped_folders("exercises"))
def test_every_shipped_exercise_can_be_read(folder):
    for path in folder.glob("*.yaml"):
        assert read_exercise(path).description


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("  - behavior: Chase\n    example: 3", ":7: `example:` is not known here"),
        ("  - decides: Chase\n    state: GoFast", "`go_to:` is missing"),
        ("  - reaches: {distance: [ball]}\n    performing: A", "needs 2 things"),
        ("  - knows: Chase", "has no known kind"),
        ("  []", "`requires:`"),
    ],
)
def test_an_exercise_that_is_wrong_is_refused_by_line(tmp_path, line, says):
    path = tmp_path / "mine.yaml"
    head = "exercise: E\ndescription: d\nswarm: keepaway\nagent: keeper_1\nrequires:\n"
    path.write_text(head + line + "\n")
    with pytest.raises(LessonError) as refused:
        read_exercise(path)
    assert says in str(refused.value)
    assert f"{shlex.quote(str(path))}:" in str(refused.value)
