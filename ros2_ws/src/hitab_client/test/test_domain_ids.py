"""The ROS domain of a swarm of its own is one that nobody on the machine uses."""

from types import SimpleNamespace

from hitab_client import domain_ids


def test_a_second_swarm_passes_over_domains_that_strangers_use(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    monkeypatch.setattr(domain_ids, "is_used_here", lambda number: number in (0, 1, 3))
    runs = [SimpleNamespace(domain_id=number) for number in (0, 2)]
    monkeypatch.setattr(domain_ids, "running_swarms", lambda: [(None, run) for run in runs])
    assert domain_ids.for_swarm() == 4
    assert domain_ids.for_swarm(refused=[4]) == 5
    runs.clear()
    assert domain_ids.for_swarm(refused=[0]) == 2
    assert domain_ids.for_swarm() == 0, "where plain ROS tools look"


def test_a_swarm_without_a_world_is_where_its_robots_drivers_are(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    runs = [(None, SimpleNamespace(domain_id=0))]
    monkeypatch.setattr(domain_ids, "running_swarms", lambda: runs)
    assert domain_ids.for_swarm() != 0
    assert domain_ids.for_swarm(has_world=False) == 0
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    assert domain_ids.for_swarm(has_world=False) == 7
