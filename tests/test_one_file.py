"""A world in one file: `hitab up` runs it, what is trained is there at the next start."""

import json
from pathlib import Path

import pytest
from waiting import within

EXAMPLES = Path(__file__).parents[1] / "examples"
CORRIDOR = (EXAMPLES / "corridor.py").read_text()
FAILS = CORRIDOR.replace("        if self.gone > 4.0", "        1 / 0\n        if self.gone > 4.0")


@pytest.fixture
def run(hitab, apart):
    def do(*command: str) -> str:
        done = hitab(*command)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return do


def test_a_file_without_a_world_is_refused_before_it_runs(hitab, apart):
    path = written(apart, "import time\nwhile True:\n    time.sleep(1)\n")
    for verb in ("up", "evaluate"):
        done = hitab(verb, path)
        assert done.returncode == 1
        assert (
            "imports nothing of HiTAB; a world is a class derived from hitab_world" in done.stderr
        )


def written(folder: Path, text: str) -> str:
    path = folder / "corridor.py"
    path.write_text(text)
    return str(path)


def test_agents_of_a_world_in_one_file_are_trained_saved_and_there_again(run, apart):
    path = written(apart, CORRIDOR)
    assert "corridor is up: 2 agents and a world" in run("up", path, "--agents", "2")
    run("train", "agent_1", "Shuttle", "-f", "Position")
    run("demonstrate", "agent_1", "Right")
    run("demonstrate", "agent_1", "Left")
    run("save", "agent_1")
    run("down")
    run("up", path, "--agents", "2")
    run("perform", "agent_1", "Shuttle")
    assert "Shuttle" in run("library", "list", "-a", "agent_1")
    told = json.loads(run("status", "--json", "-"))
    assert told["agents"][0]["behavior"] == "Shuttle"
    run("down")
    assert "-> Left" in run("library", "show", "Shuttle", "-l", "corridor/agent_1")
    run("export", "Shuttle", "-l", "corridor/agent_1", "--to", "python")
    evaluated = ("evaluate", path, "-b", "Right", "-n", "3", "--longest", "60", "--json", "-")
    first = json.loads(run(*evaluated))
    assert first["ended"]["evaluated"] == {"far": 3}
    assert first["measures"]["distance"]["evaluated"]["mean"] > 4.0
    assert json.loads(run(*evaluated))["measures"] == first["measures"]


def test_a_world_in_one_file_is_played_under_a_commander(run):
    run("up", str(EXAMPLES / "corridor_team.yaml"), "--paused")
    run("status", "--check")
    run("train", "captain", "Gather", "-f", "Middle")
    run("demonstrate", "captain", "Left")
    run("world", "step", "15")
    run("demonstrate", "captain", "Right")
    assert "orders Right: 2 of 2 perform it" in run("tree")
    run("save", "captain")
    assert "captain performs Gather" in run("order", "captain", "Gather")
    # Nothing is recorded of a state that an agent is only brought into.
    run("train", "agent_1", "Shuttle", "-f", "Position")
    run("demonstrate", "agent_1", "Right")
    told = run("demonstrate", "agent_1", "Left", "--unrecorded")
    assert "agent_1 performs Left; Shuttle has 2 examples (1 default); agent_1 was brought" in told
    assert "agent_1: Left -> Right; Shuttle has 4 examples" in run(
        "demonstrate", "agent_1", "Right"
    )
    run("discard", "agent_1", "--yes")
    assert "agent_1: Right" in run("tree"), "it obeys its commander again"
    run("down")
    ended = run(
        "evaluate", str(EXAMPLES / "corridor_team.yaml"), "-b", "captain=Gather", "-n", "2"
    )
    assert "evaluated: 2 far" in ended


def test_a_step_that_raises_is_in_the_status_with_its_line_and_the_world_goes_on_waiting(
    run, hitab, apart
):
    path = written(apart, FAILS)
    line = FAILS.splitlines().index("        1 / 0") + 1
    run("up", path)

    def failed() -> bool:
        world = json.loads(run("status", "--json", "-"))["world"]
        return world["mode"] == "paused" and f"corridor.py:{line}" in str(world)

    assert within(30.0, failed)
    step = hitab("world", "step", "5")
    assert step.returncode == 1
    told = " ".join(step.stderr.split())
    assert (
        f"the world did not reach cycle 5, but rests at cycle 0: paused: step failed: {path}"
        in told
    )
    assert hitab("status", "--check").returncode == 1
    run("down")
    assert hitab("status").returncode == 1


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("import hitab_world\n", "has no class derived from Simulation"),
        ("import hitab_world\nx = = 1\n", "corridor.py:2"),
        ("import hitab_world\nraise SystemExit(0)\n", "corridor.py:2: SystemExit"),
    ],
)
def test_a_file_that_is_no_world_does_not_start(hitab, apart, text, told):
    up = hitab("up", written(apart, text))
    assert up.returncode == 1
    assert told in up.stderr
    assert "Traceback" not in up.stderr
