"""Three keepers for all files of a folder: to start them costs more than most tests."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from keepers import begin_anew, trained_keepers

from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm


@pytest.fixture(scope="package")
def three_keepers(home: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningSwarm]:
    """Three keepers in a paused world, which the command finds too."""
    described = trained_keepers(None, "", {"taker_speed": 0.25})
    with temporary_swarm(described, tmp_path_factory.mktemp("keepers")) as running:
        running.folder.write(running.record, register=True)
        yield running


@pytest.fixture(scope="module")
def keepers(three_keepers: RunningSwarm) -> RunningSwarm:
    """Return three keepers that know nothing yet, whatever another file has taught them."""
    return begin_anew(three_keepers)


@pytest.fixture(scope="module")
def swarm(keepers: RunningSwarm) -> RunningSwarm:
    """Return three keepers for the studio, in a paused world that will run in real time."""
    keepers.world.control("pace", pace="realtime", factor=1.0)
    return keepers
