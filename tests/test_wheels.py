"""What `pip install` gives, in an empty environment outside of the checkout."""

from __future__ import annotations

import os
import subprocess
import venv
from pathlib import Path
from zipfile import ZipFile

import pytest

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = (ROOT / "docs/notebook.md").read_text().split("```")[1].removeprefix("python\n")
pytestmark = pytest.mark.long


def call(*command: str | Path, folder: Path) -> str:
    """Return what a program prints that finds nothing of this checkout."""
    variables = {
        name: value
        for name, value in os.environ.items()
        if name.startswith(("PIP_", "UV_", "SSL_", "XDG_CACHE")) or name.lower().endswith("_proxy")
    }
    variables |= {"HOME": str(folder), "PATH": "/usr/bin:/bin", "TERM": "dumb", "COLUMNS": "200"}
    done = subprocess.run(
        [str(part) for part in command],
        cwd=folder,
        env=variables,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheels(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheels")
    subprocess.run([ROOT / "scripts/wheels", folder], check=True)
    return folder


def install(wheels: Path, extras: str, folder: Path) -> Path:
    """Return the folder of programs of a new environment with the distribution `hitab`."""
    venv.create(folder / "env", with_pip=True)
    programs = folder / "env/bin"
    pip = (programs / "python", "-m", "pip", "install", "--quiet", "--find-links", wheels)
    call(*pip, f"hitab{extras}", folder=folder)
    return programs


def test_the_engine_alone_runs_without_ros_and_the_command_says_what_it_needs(
    wheels: Path, tmp_path: Path
) -> None:
    programs = install(wheels, "", tmp_path)
    assert "['Right', 'Right', 'Left', 'Left']" in call(
        programs / "python", "-c", EXAMPLE, folder=tmp_path
    )
    with pytest.raises(AssertionError, match=r'pip install --upgrade "hitab\[ros\]"'):
        call(programs / "hitab", "status", folder=tmp_path)


def test_the_sources_build_the_same_wheel_outside_of_the_checkout(
    wheels: Path, tmp_path: Path
) -> None:
    (sources,) = wheels.glob("*.tar.gz")
    (ours,) = wheels.glob("hitab-*.whl")
    venv.create(tmp_path / "env", with_pip=True)
    pip = (tmp_path / "env/bin/python", "-m", "pip", "wheel", "--quiet", "--no-deps", sources)
    call(*pip, folder=tmp_path)
    (built,) = tmp_path.glob("*.whl")
    assert set(ZipFile(built).namelist()) == set(ZipFile(ours).namelist())


def test_an_installed_hitab_is_well_and_trains_and_plays_keepaway(
    wheels: Path, tmp_path: Path
) -> None:
    programs = install(wheels, "[studio]", tmp_path)
    assert call(programs / "hitab", "--version", folder=tmp_path) == "hitab 0.1.0\n"
    doctor = call(programs / "hitab", "doctor", folder=tmp_path)
    assert "0.1.0, installed by pip" in doctor
    assert "error" not in doctor
    asked = ("env", "_HITAB_COMPLETE=complete_bash", "COMP_WORDS=hitab de", "COMP_CWORD=1")
    assert call(*asked, programs / "hitab", folder=tmp_path).split() == ["demo", "demonstrate"]
    before = set(tmp_path.glob("env/**/*[!c]"))
    said = call(programs / "hitab", "demo", "--episodes", "3", folder=tmp_path)
    assert "Taught Keepaway: 8 examples" in said
    assert f"{programs}/hitab library show Keepaway" in said  # it is not on the path
    assert (tmp_path / "hitab-demo/figures.json").is_file()
    call(programs / "hitab", "up", "keepaway", "--paused", folder=tmp_path)
    call(programs / "hitab", "down", folder=tmp_path)
    assert (tmp_path / ".local/state/hitab/keepaway/libraries").is_dir()
    made = set(tmp_path.glob("env/**/*[!c]")) - before
    assert {path.name for path in made} <= {"__pycache__"}
