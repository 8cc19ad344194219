"""A world that does not answer: why, and what to do about it."""

from types import SimpleNamespace

import pytest

from hitab_client.errors import SwarmError
from hitab_client.run_folder import RunRecord
from hitab_client.run_processes import RunProcesses
from hitab_client.world_client import WorldClient

SILENCE = SimpleNamespace(subscribe=lambda *_: None, spin_until=lambda *_, **__: False, node=None)


def record(tmp_path, *, world):
    socket = str(tmp_path / "none")
    return RunRecord(
        "gopher", "g.yaml", 7, "LOCALHOST", ("gopher_1",), world, 1, socket, "gopher-1", (), {}
    )


def why(processes, started_by_it):
    world = WorldClient(SILENCE, started_by_it=started_by_it, processes=processes)
    with pytest.raises(SwarmError) as refused:
        world.place({"gopher_1": {"x": 0.0}})
    return refused.value


def test_a_swarm_of_robots_is_not_advised_to_start_a_world(tmp_path):
    told = why(RunProcesses(record(tmp_path, world=False)), False)
    assert "this swarm has no world" in told.what
    assert told.remedies == ()
