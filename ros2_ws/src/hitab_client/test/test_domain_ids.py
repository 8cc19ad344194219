"""The ROS domain of a swarm of its own is one that nobody on the machine uses."""

from types import SimpleNamespace

import rclpy
from rclpy.context import Context

from hitab_client import domain_ids


def test_a_domain_that_somebody_uses_is_not_reserved():
    with domain_ids.reserved() as number:
        assert not domain_ids.is_used_here(number)
        context = Context()
        rclpy.init(context=context, domain_id=number)
        node = rclpy.create_node("stranger", context=context)
        try:
            assert domain_ids.is_used_here(number)
        finally:
            node.destroy_node()
            rclpy.shutdown(context=context)


def test_reserved_domains_differ():
    with domain_ids.reserved() as first, domain_ids.reserved() as second:
        assert first != second


def test_a_domain_chosen_by_hand_is_passed_over():
    with domain_ids.reserved() as free:
        pass
    context = Context()
    rclpy.init(context=context, domain_id=free)
    node = rclpy.create_node("stranger", context=context)
    try:
        with domain_ids.reserved() as other:
            assert other != free
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)


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
