"""The world of another swarm in the same ROS domain replaces nothing of one's own."""

from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import WorldState, WorldStatus

from hitab_client.connecting import identity
from hitab_client.errors import SwarmError
from hitab_client.runs import run_folder
from hitab_client.world_client import WorldClient
from hitab_core import Fix


def world_of(identity: str) -> tuple[WorldClient, dict[str, Any]]:
    takes: dict[str, Any] = {}
    link: Any = SimpleNamespace(
        subscribe=lambda kind, topic, take, *rest, **more: takes.setdefault(topic, take)
    )
    return WorldClient(link, identity=identity), takes


def test_the_state_and_status_of_another_swarms_world_replace_nothing():
    world, takes = world_of("mine-00000001")
    for swarm, cycle in (("mine-00000001", 7), ("other-00000002", 9), ("", 10)):
        takes["/world/state"](WorldState(swarm=swarm, cycle=cycle, mode=WorldState.PAUSED))
        takes["/world/status"](WorldStatus(swarm=swarm, cycle=cycle))
    assert world.state is not None
    assert world.status is not None
    assert (world.state.cycle, world.status.cycle) == (7, 7)


def test_a_verb_that_meets_another_swarm_proposes_to_stop_it_by_its_name(monkeypatch):
    records = [
        (None, SimpleNamespace(identity=f"{name}-0000000{n}", swarm=name))
        for n, name in enumerate(("mine", "other"), 1)
    ]
    monkeypatch.setattr(run_folder, "registered_swarms", lambda: iter(records))
    world, takes = world_of("mine-00000001")
    takes["/world/status"](WorldStatus(swarm="other-00000002"))
    with pytest.raises(SwarmError) as refused:
        world.refuse_strangers(world.strangers)
    assert "choose the other swarm with --swarm other-00000002" in refused.value.problem
    assert refused.value.remedies == (
        Fix.DOWN(swarm="other-00000002"),
        Fix.DOWN(swarm="mine-00000001"),
    )
    assert identity.other_swarm("a", "far-00000003", "mine-00000001").remedies == (
        Fix.DOWN(swarm="mine-00000001"),
    )
