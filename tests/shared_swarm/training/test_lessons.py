"""The lessons, played through the public topics, teach within the paper's budgets, every time."""

import signal
import subprocess
import sys

import pytest

from hitab_client.errors import LessonError
from hitab_client.lessons.lesson import parse_lesson
from hitab_client.lessons.lesson_player import LessonPlayer
from hitab_core.operations import BeginTraining, DiscardTraining, Perform

STOP = """\
lesson: Stand
agent: keeper_1
budget: 2
steps:
  - begin: Stand
    features: [BallIsKickable]
  - command: Stop
"""


def play(swarm, text: str, path):
    return LessonPlayer(parse_lesson(text, path), swarm.agents, swarm.world).play()


def lesson_file(folder, steps: str) -> str:
    path = folder / "stand.yaml"
    path.write_text(STOP + steps)
    return str(path)


def test_an_interrupted_lesson_takes_its_training_back(keepers, hitab, tmp_path):
    keepers.agents.do("keeper_1", BeginTraining("Other", features=["Done"], discard=True))
    keepers.agents.do("keeper_1", DiscardTraining())
    keepers.agents.do("keeper_2", Perform())
    agents = keepers.agents
    assert keepers.link.spin_until(lambda: not agents.statuses["keeper_2"].behavior, 30)
    mate = "  - {perform: GoFast, agents: [keeper_2]}\n"
    long = lesson_file(tmp_path, f"{mate}  - wait: 600\n")
    command = subprocess.Popen(
        [sys.executable, "-m", "hitab_cli.main", "lesson", "run", long, "--factor", "1"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert keepers.link.spin_until(lambda: agents.statuses["keeper_2"].behavior == "GoFast", 30)
    taught = keepers.link.spin_until(
        lambda: agents.statuses["keeper_1"].training.examples == 2, 30
    )
    command.send_signal(signal.SIGINT)
    _, told = command.communicate(timeout=30)
    assert taught, told
    assert command.returncode == 130
    assert 'keeper_1 is idle; discarded "Stand" with 2 unsaved examples' in told
    assert "keeper_2 goes on performing GoFast" in told
    assert "Traceback" not in told
    assert keepers.link.spin_until(lambda: keepers.world.status.mode == "paused", 5)
    again = hitab("lesson", "run", lesson_file(tmp_path, "  - save: true\n"))
    assert again.returncode == 0, again.stderr


def test_a_lesson_that_fails_says_what_it_leaves_and_discards_it_when_asked_to(
    keepers, hitab, tmp_path
):
    keepers.agents.do("keeper_1", BeginTraining("Other", features=["Done"], discard=True))
    failed = hitab("lesson", "run", lesson_file(tmp_path, "  - never: {seconds: 0.2}\n"))
    assert failed.returncode == 1
    assert "this should not happen" in failed.stderr
    assert "`hitab save keeper_1`" in failed.stderr
    lesson = lesson_file(tmp_path, "  - save: true\n")
    refused = hitab("lesson", "run", lesson)
    assert refused.returncode == 1
    assert "`hitab discard keeper_1`" in refused.stderr
    done = hitab("lesson", "run", lesson, "--discard")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("steps", "line", "expected"),
    [
        (
            "  - until: {said: keeper_1}\n    within: 0.5\n",
            8,
            "waited 0.5 s in vain until keeper_1 has said",
        ),
        ("  - check: {speed: keeper_1, above: 1}\n    within: 0.5\n", 8, "teach more examples"),
        ("  - command: Dance\n", 8, 'step `command`: keeper_1: unknown behavior "Dance"'),
        ("  - command: Stop\n  - save: true\n", None, "took 3 examples, including default ones"),
    ],
)
def test_what_goes_wrong_is_told_by_file_line_and_step(keepers, tmp_path, steps, line, expected):
    keepers.agents.do("keeper_1", BeginTraining("Other", features=["Done"], discard=True))
    path = tmp_path / "stand.yaml"
    with pytest.raises(LessonError) as error:
        play(keepers, STOP + steps, path)
    assert str(error.value).startswith(f"{path}:{line}: step" if line else f"{path}: took")
    assert expected in str(error.value)
