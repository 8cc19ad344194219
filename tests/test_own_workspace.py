"""The way of rosdep and colcon: its scripts, container and public checks say the same."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
WORKFLOW = ROOT / ".github" / "workflows" / "ci.yml"
PAGE = (ROOT / "docs" / "installed-jazzy.md").read_text()


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
