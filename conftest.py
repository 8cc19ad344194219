"""What holds for all tests of this checkout."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

# How long an example takes, or takes to be made, says how busy the machine is, not whether the
# code is right.
settings.register_profile("hitab", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("hitab")

# A shell that runs this in the background has its processes ignore Ctrl-C, and so those that the
# tests start; with a handler of its own these begin with the default again.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option for the tests that are marked as long."""
    parser.addoption("--long", action="store_true", help="also the tests that take long")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out the tests that take long, unless they are asked for."""
    if config.getoption("long"):
        return
    left_out = [item for item in items if item.get_closest_marker("long")]
    config.hook.pytest_deselected(items=left_out)
    items[:] = [item for item in items if not item.get_closest_marker("long")]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Keep the tests of a file on one core, and those of a folder that shares a swarm."""
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = super()._split_scope(nodeid)
            return file.rpartition("/")[0] if "/shared_swarm/" in file else file

    return Scheduling(config, log) if config.getoption("dist") == "loadfile" else None


@pytest.fixture(scope="session")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Keep away from the user's own swarms, and from those of the domain that the user chose."""
    folder = tmp_path_factory.mktemp("home")
    before = {name: os.environ.pop(name, None) for name in ("HITAB_HOME", "ROS_DOMAIN_ID")}
    os.environ["HITAB_HOME"] = str(folder)
    yield folder
    del os.environ["HITAB_HOME"]
    os.environ.update({name: value for name, value in before.items() if value is not None})
