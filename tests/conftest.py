"""Swarms for the tests: real nodes in processes of their own, in a ROS domain nobody else uses."""

import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import warm_hitab
from browsing import Person, browser, studio
from robot_desk import Desk, desk_with

from hitab_bringup.processes import supervision
from hitab_bringup.processes.bringing_up import RunningSwarm
from hitab_client import domain_ids
from hitab_client.runs.run_folder import running_swarms


@pytest.fixture(scope="session")
def hitab(home: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Return a function that runs the command in a process of its own, as a user does."""

    def run(*arguments: str, timeout: float = 60.0) -> subprocess.CompletedProcess[str]:
        environment = {**os.environ, "COLUMNS": "200"}
        done = warm_hitab.run(("hitab", *arguments), Path.cwd(), environment, timeout)
        return subprocess.CompletedProcess(arguments, *done)

    return run


@pytest.fixture
def apart(home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a folder to write into, in a ROS domain apart; swarms that are left are stopped."""
    monkeypatch.chdir(tmp_path)
    with domain_ids.reserved() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        yield tmp_path
        monkeypatch.setenv("HITAB_HOME", str(home))
        for folder, _ in list(running_swarms()):
            supervision.stop(folder)


@pytest.fixture(scope="module")
def url(swarm: RunningSwarm, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Return the address of the studio that shows the swarm."""
    with studio(tmp_path_factory.mktemp("studio") / "log") as address:
        yield address


@pytest.fixture(scope="module")
def chrome() -> Iterator[Any]:
    """Return a browser; while it is there, an event loop runs that other files cannot have."""
    with browser() as started:
        yield started


@pytest.fixture(scope="module")
def window(chrome: Any) -> Iterator[Any]:
    """Return a window for those who sit at it one after the other: each costs seconds to open."""
    page = chrome.new_page()
    yield page
    page.close()


@pytest.fixture
def person(window: Any, url: str) -> Iterator[Person]:
    """Return somebody at the page; the console stays without errors, whatever they do."""
    window.set_viewport_size({"width": 1280, "height": 720})
    someone = Person(window, url)
    someone.sees_field()
    yield someone
    someone.leave()
    assert someone.complaints == []


@pytest.fixture(scope="module")
def shared_desk(home: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    with desk_with(tmp_path_factory.mktemp("desk")) as there:
        yield there


@pytest.fixture
def desk(shared_desk: Desk) -> Desk:
    """Return a simulated robot of examples/diff_drive and its agent, as they are at first."""
    shared_desk.rest()
    return shared_desk


@pytest.fixture
def lossy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: Any) -> None:
    """Have the processes that are started from now on lose every n-th of what they send."""
    if shutil.which("cc") is None:
        pytest.skip("there is no C compiler")
    library = tmp_path / "lossy_sender.so"
    source = Path(__file__).with_name("lossy_sender.c")
    subprocess.run(["cc", "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)
    monkeypatch.setenv("LOSES_EVERY", str(request.param))
    monkeypatch.setenv("LD_PRELOAD", str(library))
