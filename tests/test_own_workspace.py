"""The way of rosdep and colcon: its scripts, container and public checks say the same."""

import os
import re
import subprocess
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
WORKFLOW = ROOT / ".github" / "workflows" / "ci.yml"
PAGE = (ROOT / "docs" / "installed-jazzy.md").read_text()


@pytest.mark.parametrize("script", ["docker/build", "docker/entrypoint"])
def test_the_scripts_can_be_run_and_read_by_bash(script):
    assert os.access(ROOT / script, os.X_OK)
    assert subprocess.run(["bash", "-n", ROOT / script], check=False).returncode == 0


def test_the_workflow_runs_scripts_that_there_are():
    jobs = yaml.safe_load(WORKFLOW.read_text())["jobs"]
    lines = "\n".join(step.get("run", "") for job in jobs.values() for step in job["steps"])
    called = set(re.findall(r"\b(?:scripts|docker)/\w+", lines))
    assert called == {"scripts/test", "scripts/docs", "docker/build", "docker/entrypoint"}
    assert all(os.access(ROOT / script, os.X_OK) for script in called)
    assert subprocess.run(["bash", "-n"], input=lines, text=True, check=False).returncode == 0


def test_the_container_and_the_workflow_install_the_same():
    texts = [(ROOT / "docker/Dockerfile").read_text(), WORKFLOW.read_text()]
    installs = [
        set(
            re.findall(
                r"(?:rosdep (?:install|update)|apt-get install) .*?(?=\s*(?:\\|&&|$))", text, re.M
            )
        )
        for text in texts
    ]
    assert installs[0] == installs[1]
    assert len(installs[0]) == 3


def test_the_page_shows_what_the_build_does():
    done = (ROOT / "docker/build").read_text().replace('"$env/', "env/").replace('"$env"', "env")
    assert "-m venv --system-site-packages env" in done
    for shown in ("-m venv --system-site-packages env", "requirements/beside-rosdep.txt"):
        assert shown in PAGE
        assert shown in done
    assert "-m colcon build --base-paths ros2_ws/src" in PAGE
    assert "-m colcon build --base-paths ros2_ws/src" in done
