"""A robot and a world of one's own, as `hitab new` writes them."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import warm_hitab
from mentions import ROOT


@pytest.fixture
def run(apart):
    """Return a function that runs a command where what it installs is apart too."""
    environment = {
        **os.environ,
        "COLUMNS": "200",
        "PYTHONPATH": os.pathsep.join(
            [str(apart / "installed"), *filter(None, [os.environ.get("PYTHONPATH")])]
        ),
    }

    def do(*command: str, fails: bool = False) -> str:
        if command[0] == "hitab":
            status, out, err = warm_hitab.run(command, apart, environment, 120.0)
        else:
            done = subprocess.run(command, env=environment, capture_output=True, text=True)
            status, out, err = done.returncode, done.stdout, done.stderr
        assert (status != 0) == fails, out + err
        return out + err

    return do


def test_a_new_robot_is_tested_installed_started_and_trained(run, apart):
    told = run("hitab", "new", "lift")
    assert "pip install" in told
    assert "hitab arm robot_1" in told
    page = (ROOT / "docs/your-own-robot.md").read_text(encoding="utf-8")
    (link,) = re.findall(r"```python\n(.*class Link.*?)```", page, re.DOTALL)
    assert link.count("\n") <= 50
    (apart / "lift/lift/link.py").write_text(link)  # that of the page is run
    run(
        sys.executable,
        "-m",
        "pip",
        "install",
        "--no-build-isolation",
        "--no-deps",
        "--target",
        "installed",
        "./lift",
    )
    assert "1 passed" in run(sys.executable, "-m", "pytest", "lift")
    run("hitab", "up", "lift/swarm.yaml")
    run("hitab", "arm", "robot_1")
    run("hitab", "train", "robot_1", "Shuttle", "-f", "Position")
    run("hitab", "demonstrate", "robot_1", "Right")
    run("hitab", "demonstrate", "robot_1", "Left")
    assert "with 4 examples" in run("hitab", "save", "robot_1")
    run("hitab", "down")


def test_a_new_robot_with_standard_messages_is_tested_and_has_no_link_of_its_own(run, apart):
    assert "link.py" not in run("hitab", "new", "rover", "--standard")
    tested = run(sys.executable, "-m", "pytest", "-o", "pythonpath=rover", "rover")
    assert "2 passed" in tested
    names = {str(path.relative_to("rover")) for path in Path("rover").rglob("*.*")}
    assert {"rover/domain.py", "setup.py", "package.xml", "swarm.yaml"} <= names
    assert "rover/link.py" not in names
    domain = (apart / "rover/rover/domain.py").read_text()
    assert 'link="hitab_robots:RobotLink"' in domain
    refused = run("hitab", "new", "pond", "--world", "--standard", fails=True)
    assert "leave out --world" in " ".join(refused.split())


def test_a_new_world_is_tested_started_and_trained(run):
    run("hitab", "new", "pond", "--world")
    assert "1 passed" in run(sys.executable, "-m", "pytest", "pond.py")
    run("hitab", "up", "pond.py")
    run("hitab", "train", "agent_1", "Shuttle", "-f", "Position")
    run("hitab", "demonstrate", "agent_1", "Right")
    assert "with 2 examples" in run("hitab", "save", "agent_1")
    run("hitab", "down")


def test_what_exists_is_kept_and_a_name_that_cannot_be_used_is_refused(run, apart):
    (apart / "lift").mkdir()
    assert "lift exists already; choose another name" in run("hitab", "new", "lift", fails=True)
    for name in ("My-Robot", "../up", "class", "x__y"):
        assert "is not a name for a package" in run("hitab", "new", name, fails=True)
    for name in ("json", "keepaway"):
        assert "that is installed; choose another" in run("hitab", "new", name, fails=True)
    assert [path.name for path in Path().iterdir()] == ["lift"]
