"""The command: quick, helpful, and without tracebacks for a user's mistakes."""

import re
import subprocess
import sys
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from hitab_cli.main import make_app

HEAVY = ("rclpy", "numpy", "matplotlib", "psutil", "sklearn", "hitab_msgs", "pymunk")


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """Keep away from the user's own swarms."""
    monkeypatch.setenv("HITAB_HOME", str(tmp_path / "home"))
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    monkeypatch.chdir(tmp_path)


def hitab(*arguments: str):
    return CliRunner().invoke(make_app(), list(arguments), env={"COLUMNS": "120", "TERM": "dumb"})


def in_one_line(text: str) -> str:
    return re.sub(r"[\s│╭╮╰╯─]+", " ", text)


def test_help_imports_nothing_that_takes_long():
    script = (
        "import sys\nfrom hitab_cli.main import make_app\n"
        "try:\n    make_app()(['--help'])\nexcept SystemExit:\n    pass\n"
        f"print('loaded', [m for m in {HEAVY!r} if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "loaded []"


@pytest.mark.parametrize(
    ("arguments", "code", "expected"),
    [
        (["demonstrat"], 2, "No such command"),
        (["up", "keepaway", "--pace", "fast"], 2, "is not one of 'lockstep', 'realtime'"),
        (["train", "keeper_1", "A", "-p", "ball"], 2, "is not NAME=TARGET"),
        (["examples", "delte", "keeper_1", "3"], 2, "Did you mean 'delete'"),
        (["library", "list", "-l", "nowhere"], 1, "is neither a folder nor a library"),
        (["library", "show", "A", "--agent", "keeper_1"], 1, "no swarm is up"),
    ],
)
def test_a_users_mistake_is_told_in_words(arguments, code, expected):
    result = hitab(*arguments)
    output = in_one_line(result.stderr + result.stdout)
    assert result.exit_code == code, output
    assert expected in output
    assert "Traceback" not in output


def test_down_stops_all_swarms_if_that_is_said(tmp_path, monkeypatch):
    from hitab_bringup.processes import supervision
    from hitab_client import RunFolder, RunRecord

    record = RunRecord("red", "r.yaml", 3, "LOCALHOST", ("a",), True, 1, "s", "red-0a1b2c3d")
    for name in ("one", "two"):
        folder = RunFolder(tmp_path / name)
        folder.prepare()
        folder.write(replace(record, swarm=name, identity=f"{name}-0a1b2c3d"), register=True)
    stopped = []
    monkeypatch.setattr(supervision, "stop", lambda folder: stopped.append(folder.path) or [])
    assert hitab("down", "one", "--all").exit_code == 2
    assert hitab("down", "--all").stdout == "one is down\ntwo is down\n"
    assert stopped == [tmp_path / "one", tmp_path / "two"]


def test_who_interrupts_down_learns_how_to_end_the_rest(tmp_path, monkeypatch):
    from hitab_bringup.processes import supervision

    def interrupted(folder):
        raise KeyboardInterrupt

    monkeypatch.setattr(supervision, "stop", interrupted)
    result = hitab("down", "--run-dir", str(tmp_path))
    assert result.exit_code == 130
    assert f"end what is left of it: `hitab down --run-dir {tmp_path}`" in result.stderr
