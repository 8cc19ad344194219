"""A paused swarm of any size sends only what its few processes send, and has few endpoints."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from hitab_msgs import msg

from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_client.runs.shipped import shipped
from hitab_ros import names, qos

SECONDS = 60.0
IDLE_STATUSES = 4  # of the world, which sends one a second
HOSTS = 2
ENDPOINTS = {"forager": 1, "squad": 4}
"""Endpoints of a node that nobody has asked for anything: the status; a commander's status, group,
orders and reports."""


def description(agents: int) -> str:
    return f"""
swarm: idle
domain: foraging
start_from: {shipped("libraries", "foraging")}
behavior: Search
hosts: {HOSTS}
world:
  kind: foraging
  parameters: {{foragers: {agents}, width: 200.0, height: 200.0}}
  paused: true
agents:
  forager: {{count: {agents}}}
kinds:
  Leader: {{orders: {{Search: Search, Stop: Stop}}}}
commanders:
  squad: {{kind: Leader, commands: {{forager: 5}}}}
"""


def endpoints_of(swarm: RunningSwarm, name: str, kind: str) -> int:
    node = swarm.link.node
    queries = (
        node.get_publisher_names_and_types_by_node,
        node.get_subscriber_names_and_types_by_node,
        node.get_service_names_and_types_by_node,
        node.get_client_names_and_types_by_node,
    )
    return sum(len(query(kind, f"/{name}")) for query in queries)


@pytest.mark.parametrize("agents", [20, 100, pytest.param(1000, marks=pytest.mark.long)])
def test_what_does_not_change_costs_no_message_and_who_is_not_asked_has_few_endpoints(
    home: Path, tmp_path: Path, agents: int
) -> None:
    with temporary_swarm(parse_swarm(description(agents), tmp_path / "idle.yaml")) as swarm:
        link, came = swarm.link, Counter[str]()
        for name in swarm.record.commanders:
            for kind, topic, profile in (
                (msg.Reports, names.REPORTS, qos.EVENTS),
                (msg.Order, names.ORDER, qos.LATCHED),
                (msg.CommanderStatus, names.GROUP, qos.LATCHED),
            ):
                link.subscribe(
                    kind, f"/{name}/{topic}", lambda _, topic=topic: came.update([topic]), profile
                )
        for name in swarm.record.agents:
            link.subscribe(
                msg.AgentStatus, f"/{name}/status", lambda _: came.update(["status"]), qos.LATCHED
            )
        link.subscribe(
            msg.Alive, f"/{names.ALIVE}", lambda _: came.update(["alive"]), qos.SIGNS_OF_LIFE
        )
        link.subscribe(
            msg.WorldStatus, "/world/status", lambda _: came.update(["world"]), qos.LATCHED
        )

        def idle() -> bool:
            """Note what comes during some seconds; return whether only the processes sent it."""
            came.clear()
            link.spin_until(lambda: came["world"] >= IDLE_STATUSES, SECONDS)
            return came.keys() <= {"alive", "world"}

        assert link.spin_until(idle, SECONDS), came
        # Two signs of life a second from each host and from the world.
        assert came["alive"] <= 2 * (HOSTS + 1) * (IDLE_STATUSES + 1)
        assert endpoints_of(swarm, "forager_1", "agent") == ENDPOINTS["forager"]
        assert endpoints_of(swarm, "squad_1", "commander") == ENDPOINTS["squad"]
