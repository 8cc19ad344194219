"""Many agents in few processes: each is a node like any other, at a fraction of its cost."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hitab_msgs import msg

from hitab_bringup.bringing_up import RunningSwarm, temporary_swarm
from hitab_bringup.swarm_file import parse_swarm
from hitab_client.errors import SwarmError

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
AGENTS = 60
SECONDS = 60.0


@pytest.fixture(scope="module")
def swarm(home: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningSwarm]:
    """Return a swarm of the benchmark: agents and commanders of three levels in two hosts."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(BENCHMARKS))
        patch.syspath_prepend(str(BENCHMARKS))
        import swarms

        folder = tmp_path_factory.mktemp("scale")
        description = parse_swarm(swarms.description(AGENTS, 2), folder / "scale.yaml")
        with temporary_swarm(description, folder / "run") as running:
            yield running
    sys.modules.pop("swarms", None)


def performed(swarm: RunningSwarm) -> set[str]:
    return {
        status.behavior
        for name, status in swarm.agents.statuses.items()
        if name.startswith("ant_")
    }


def test_an_order_at_the_root_reaches_every_agent(swarm: RunningSwarm) -> None:
    assert len(swarm.agents.statuses) == AGENTS + 12 + 3 + 1
    for order in ("Patrol", "Wait", "Explore"):
        swarm.agents.perform("root", order)
        assert swarm.link.spin_until(lambda order=order: performed(swarm) == {order}, SECONDS)


def test_hosted_agents_act_in_the_world(swarm: RunningSwarm) -> None:
    swarm.agents.perform("root", "Explore")
    assert swarm.link.spin_until(lambda: performed(swarm) == {"Explore"}, SECONDS)
    deciding = swarm.agents.statuses
    ants = [f"ant_{i + 1}" for i in range(AGENTS)]
    assert swarm.link.spin_until(lambda: all(deciding[n].active_path for n in ants), SECONDS)
    assert not swarm.world.status.missing
    # Where all walk and turn, nobody stays where he was.
    states: list[msg.WorldState] = []
    swarm.link.subscribe(msg.WorldState, "/world/state", states.append, 10)

    def moved() -> bool:
        if len(states) < 2:
            return False
        pairs = zip(states[0].entities, states[-1].entities, strict=True)
        moving = [(a.x, a.y, a.heading) != (b.x, b.y, b.heading) for a, b in pairs]
        return len(moving) >= AGENTS and all(moving)

    assert swarm.link.spin_until(moved, SECONDS)


def test_each_agent_is_a_node_with_topics_and_services_of_its_own(swarm: RunningSwarm) -> None:
    node = swarm.link.node

    def services() -> set[str]:
        return {name for name, _ in node.get_service_names_and_types()}

    nodes = {f"{space.rstrip('/')}/{name}" for name, space in node.get_node_names_and_namespaces()}
    assert {f"/ant_{i + 1}/agent" for i in range(AGENTS)} <= nodes
    # They are made when the first client asks.
    assert "/ant_60/perform" not in services()
    swarm.agents.perform("ant_60", "Walk")
    assert "/ant_60/save" in services()
    assert "/ant_59/save" not in services()
    assert swarm.link.spin_until(lambda: "Walk" in performed(swarm), SECONDS)
    assert "Patrol" in swarm.agents.vocabulary("ant_60").behaviors
    with pytest.raises(SwarmError, match="unknown behavior"):
        swarm.agents.perform("ant_59", "Fly")


def test_one_hosted_agent_is_trained_while_the_others_go_on(swarm: RunningSwarm) -> None:
    swarm.agents.perform("root", "Patrol")
    assert swarm.link.spin_until(lambda: performed(swarm) == {"Patrol"}, SECONDS)
    swarm.agents.begin("ant_7", "Stroll", features=["Heading"])
    assert swarm.agents.command("ant_7", "Walk").examples == 2
    swarm.agents.set_mode("ant_7", "testing", restart=True)
    assert swarm.link.spin_until(
        lambda: list(swarm.agents.statuses["ant_7"].active_path) == ["Walk"], SECONDS
    )
    swarm.agents.save("ant_7")
    swarm.agents.perform("ant_7", "Patrol")
    assert swarm.link.spin_until(lambda: performed(swarm) == {"Patrol"}, SECONDS)
