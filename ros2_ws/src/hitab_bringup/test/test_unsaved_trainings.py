"""An unsaved training resumes only with its own library, and `hitab up` reports it."""

from pathlib import Path

import pytest
from hitab_msgs.msg import AgentStatus

from hitab_bringup.libraries.library_choice import with_library
from hitab_bringup.libraries.run_libraries import prepare
from hitab_bringup.libraries.unsaved_trainings import (
    announcements,
    left_to_resume,
    set_aside,
    waiting,
)
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_core import Example
from hitab_core.assistant import unsaved_cost
from hitab_core.training import Curriculum, TrainingJournal

LONE = "swarm: lone\ndomain: keepaway\nagents: {lone: {}}\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    run = tmp_path / "run"
    run.mkdir()
    return run


def start(folder: Path, library: str = "") -> None:
    """Prepare a start as `hitab up` does."""
    swarm = parse_swarm(LONE, folder / "lone.yaml")
    prepare(with_library(swarm, library) if library else swarm, folder)


def train(folder: Path, name: str) -> None:
    """Begin a training and end the process."""
    journal = TrainingJournal(folder / "state" / "lone", "keepaway")
    journal.begin(Curriculum(name, ()), (), ())
    journal.close()


def resumes(folder: Path) -> str:
    """Return the training that the next start resumes; empty if none."""
    unsaved = unsaved_cost(TrainingJournal(folder / "state" / "lone"))
    return "" if unsaved is None else unsaved.automaton


def test_a_training_does_not_resume_with_another_library_and_comes_back_with_its_own(folder):
    start(folder)
    train(folder, "Own")
    start(folder)
    assert resumes(folder) == "Own"

    other = str(folder.parent / "other")
    start(folder, other)
    assert resumes(folder) == ""
    assert announcements([], folder) == [
        "lone has another unsaved training; start the swarm without --library to resume it"
    ]
    train(folder, "Other")

    start(folder)
    assert resumes(folder) == "Own"
    assert list(waiting(folder)) == [("lone", Path(other))]
    assert announcements([], folder)[0].endswith(
        f"start the swarm with --library {other} to resume it"
    )

    train(folder, "Another")  # in place of its own
    start(folder, other)
    assert resumes(folder) == "Other"


def test_what_waits_for_a_library_is_known_while_the_agent_trains(folder):
    start(folder)
    train(folder, "Own")
    other = folder.parent / "other"
    start(folder, str(other))
    journal = TrainingJournal(folder / "state" / "lone", "keepaway")
    journal.begin(Curriculum("Other", ()), (), ())
    assert list(waiting(folder)) == [("lone", folder / "libraries" / "lone")]
    journal.close()


def test_a_start_that_is_killed_between_loses_no_training(folder):
    start(folder)
    train(folder, "Own")
    own, other = folder / "libraries" / "lone", folder.parent / "other"
    set_aside({"lone": own}, {"lone": other}, folder)
    start(folder)
    assert resumes(folder) == "Own"


def test_a_damaged_database_does_not_keep_a_swarm_from_starting(folder):
    start(folder)
    train(folder, "Own")
    (folder / "state" / "lone" / "agent.db").write_bytes(b"damaged" * 1000)
    start(folder)


def test_a_training_that_resumes_is_announced_with_the_ways_out(folder):
    status = AgentStatus(agent="lone", mode=AgentStatus.TRAINING, behavior="Chase")
    status.training.examples = 8
    idle = AgentStatus(agent="other", mode=AgentStatus.IDLE)
    assert announcements([status, idle], folder) == [
        'lone resumes the training of "Chase" (8 examples) and waits for commands\n'
        "  test what lone has learned: `hitab test lone`\n"
        "  save the training of lone: `hitab save lone`\n"
        "  discard the training of lone: `hitab discard lone`"
    ]
    assert announcements([status] * 8, folder)[-1] == "... and 3 more"


def test_of_a_commander_that_resumes_a_training_it_is_said_that_its_group_waits(folder):
    status = AgentStatus(agent="chief", mode=AgentStatus.TRAINING, behavior="Lead")
    status.training.examples = 2
    sentence = announcements([status], folder, ["chief"])[0]
    assert "waits for commands; its group waits for its orders\n" in sentence


def test_a_swarm_that_goes_down_names_the_trainings_that_it_keeps(folder):
    for agent, examples in (("b", 1), ("a", 2), ("empty", 0)):
        kept = TrainingJournal(folder / "state" / agent, "keepaway")
        named = [Example("Stop", (), "Stop", number=n, command=n) for n in range(1, examples + 1)]
        kept.begin(Curriculum("Chase", ()), named, ())
        kept.close()
    assert left_to_resume(folder) == [
        f'{agent} has an unsaved training of "Chase" ({examples}); it is kept, and the next '
        "start of the swarm resumes it"
        for agent, examples in (("a", "2 examples"), ("b", "1 example"))
    ]
    saved = TrainingJournal(folder / "state" / "b", "keepaway")
    saved.begin(Curriculum("Chase", ()), [Example("Stop", (), "Stop", number=1, command=1)], ())
    saved.write({"do": "save", "automaton": "Chase", "checksum": "0"})
    saved.archive()
    assert [text.split()[0] for text in left_to_resume(folder)] == ["a"]
