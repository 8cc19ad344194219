"""Many agents in few processes: each is a node like any other, at a fraction of its cost."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_client.errors import SwarmError
from hitab_client.runs.shipped import shipped
from hitab_core.operations import BeginTraining, Command, Perform, SaveBehavior, Test

AGENTS = 60
SECONDS = 60.0
SWARM = f"""
swarm: scale
domain: foraging
start_from: {shipped("libraries", "foraging")}
behavior: Search
hosts: 2
world:
  kind: foraging
  parameters: {{foragers: {AGENTS}, width: 200.0, height: 200.0}}
agents:
  forager: {{count: {AGENTS}}}
kinds:
  Leader: {{orders: {{Search: Search, RotateLeft: RotateLeft, Stop: Stop}}}}
commanders:
  squad: {{kind: Leader, commands: {{forager: 5}}}}
  company: {{kind: Leader, commands: {{squad: 4}}}}
  root: {{kind: Leader, commands: company}}
"""


@pytest.fixture(scope="module")
def swarm(home: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningSwarm]:
    """Return a swarm of agents and commanders of three levels in two hosts."""
    folder = tmp_path_factory.mktemp("scale")
    description = parse_swarm(SWARM, folder / "scale.yaml")
    with temporary_swarm(description, folder / "run") as running:
        yield running


def performed(swarm: RunningSwarm) -> set[str]:
    return {
        status.behavior
        for name, status in swarm.agents.statuses.items()
        if name.startswith("forager_")
    }


def test_an_order_at_the_root_reaches_every_agent(swarm: RunningSwarm) -> None:
    assert len(swarm.agents.statuses) == AGENTS + 12 + 3 + 1
    for order in ("RotateLeft", "Stop", "Search"):
        swarm.agents.do("root", Perform(order))
        assert swarm.link.spin_until(lambda order=order: performed(swarm) == {order}, SECONDS)


def test_each_agent_is_a_node_with_topics_and_services_of_its_own(swarm: RunningSwarm) -> None:
    node = swarm.link.node

    def services() -> set[str]:
        return {name for name, _ in node.get_service_names_and_types()}

    nodes = {f"{space.rstrip('/')}/{name}" for name, space in node.get_node_names_and_namespaces()}
    assert {f"/forager_{i + 1}/agent" for i in range(AGENTS)} <= nodes
    # Each is made when the first client asks.
    assert "/forager_60/perform" not in services()
    swarm.agents.do("forager_60", Perform("Forward"))
    assert "/forager_60/perform" in services()
    assert "/forager_60/save_behavior" not in services()
    assert swarm.link.spin_until(lambda: "Forward" in performed(swarm), SECONDS)
    assert "RotateLeft" in [b.name for b in swarm.agents.vocabulary("forager_60").behaviors]
    with pytest.raises(SwarmError, match="unknown behavior"):
        swarm.agents.do("forager_59", Perform("Fly"))


def test_one_hosted_agent_is_trained_while_the_others_go_on(swarm: RunningSwarm) -> None:
    swarm.agents.do("root", Perform("RotateLeft"))
    assert swarm.link.spin_until(lambda: performed(swarm) == {"RotateLeft"}, SECONDS)
    swarm.agents.do("forager_7", BeginTraining("Stroll", features=["HoldsABox"]))
    assert swarm.agents.do("forager_7", Command("Forward")).status.training.examples == 2
    swarm.agents.do("forager_7", Test(restart=True))
    assert swarm.link.spin_until(
        lambda: list(swarm.agents.statuses["forager_7"].active_path) == ["Forward"], SECONDS
    )
    swarm.agents.do("forager_7", SaveBehavior())
    swarm.agents.do("forager_7", Perform("RotateLeft"))
    assert swarm.link.spin_until(lambda: performed(swarm) == {"RotateLeft"}, SECONDS)
