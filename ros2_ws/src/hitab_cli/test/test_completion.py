"""The shell completes verbs and names, without loading ROS."""

import os
import subprocess
import sys

import pytest

from hitab_client import RunFolder, RunRecord

NAMES = ("keeper_1", "keeper_2", "taker_1")


@pytest.fixture
def up(tmp_path, monkeypatch):
    """Register a swarm whose supervisor is a process of this test."""
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    folder = RunFolder.of_swarm("team")
    folder.prepare()
    folder.configuration.write_text("")
    supervisor = subprocess.Popen(
        [sys.executable, "-c", "input()", str(folder.configuration)],
        stdin=subprocess.PIPE,
        env={**os.environ, "HITAB_RUN_FOLDER": str(folder.path)},
    )
    record = RunRecord(
        "team", "t.yaml", 7, "LOCALHOST", NAMES, True, supervisor.pid, "s", "team-1",
        ("taker_1",), {"world": (), "host_1": NAMES},
    )  # fmt: skip
    folder.write(record, register=True)
    yield
    supervisor.kill()
    supervisor.communicate()


def completed(line: str) -> list[str]:
    """Return what bash is offered, asked as its completion function does."""
    words = line.split(" ")
    script = (
        "import sys\nsys.modules['rclpy'] = None\nsys.argv = ['hitab']\n"
        "from hitab_cli.main import main\nmain()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        env={
            **os.environ,
            "_HITAB_COMPLETE": "complete_bash",
            "COMP_WORDS": line,
            "COMP_CWORD": str(len(words) - 1),
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert "Error" not in done.stderr
    return done.stdout.split()


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("hitab sta", ["status"]),
        ("hitab demonstrate kee", ["keeper_1", "keeper_2"]),
        ("hitab logs h", ["host_1"]),
        ("hitab status --swarm te", ["team"]),
        ("hitab train --swarm nobody kee", []),
        ("hitab up thou", ["thousand"]),
    ],
)
def test_the_shell_is_offered(up, line, offered):
    assert completed(line) == offered
