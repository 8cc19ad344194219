"""Three keepers for all files of a folder: to start them costs more than most tests."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from keepers import begin_anew, registered, trained_keepers

from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm


@pytest.fixture(scope="package")
def three_keepers(home: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningSwarm]:
    """Three keepers in a paused world, which the command finds too."""
    described = trained_keepers(None, "", {"taker_speed": 0.25})
    folder = tmp_path_factory.mktemp("keepers")
    with temporary_swarm(described, folder) as running, registered(running, home):
        yield running


@pytest.fixture(scope="module")
def keepers(three_keepers: RunningSwarm) -> RunningSwarm:
    """Return three keepers that know nothing yet, whatever another file has taught them."""
    begin_anew(three_keepers)
    return three_keepers
