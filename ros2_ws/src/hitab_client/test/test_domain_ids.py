"""The ROS domain reserved for a swarm is unused on the machine."""

import os
import subprocess
import sys
from types import SimpleNamespace

from hitab_client import RunFolder, RunRecord, domain_ids
from hitab_client.runs.run_folder import MARK


def test_a_second_swarm_passes_over_domains_that_strangers_use(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    monkeypatch.setattr(domain_ids, "is_used_here", lambda number: number in (0, 1, 3))
    runs = [SimpleNamespace(domain_id=number) for number in (0, 2)]
    monkeypatch.setattr(domain_ids, "swarms_here", lambda: [(None, run) for run in runs])
    assert domain_ids.for_swarm() == 4
    assert domain_ids.for_swarm(refused=[4]) == 5
    runs.clear()
    assert domain_ids.for_swarm(refused=[0]) == 2
    assert domain_ids.for_swarm() == 0, "where plain ROS tools look"


def test_a_swarm_without_a_world_is_where_its_robots_drivers_are(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    runs = [(None, SimpleNamespace(domain_id=0))]
    monkeypatch.setattr(domain_ids, "swarms_here", lambda: runs)
    assert domain_ids.for_swarm() != 0
    assert domain_ids.for_swarm(is_free=False) == 0
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    assert domain_ids.for_swarm(is_free=False) == 7


def test_a_swarm_of_another_state_folder_is_passed_over(monkeypatch, tmp_path):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    monkeypatch.setenv("HITAB_HOME", str(tmp_path / "mine"))
    folder = RunFolder(tmp_path / "theirs" / "two")
    folder.prepare()
    number = domain_ids.for_swarm()
    supervisor = subprocess.Popen(
        [sys.executable, "-c", "input()", str(folder.configuration)],
        stdin=subprocess.PIPE,
        env={**os.environ, MARK: str(folder.path)},
    )
    with supervisor:
        folder.write(
            RunRecord("two", "", number, "LOCALHOST", (), True, supervisor.pid, ""),
            register=False,
        )
        assert domain_ids.for_swarm() != number
        supervisor.kill()
    assert domain_ids.for_swarm() == number
