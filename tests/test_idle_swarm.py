"""A swarm in which nothing changes sends only what its few processes send; endpoints are few."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from hitab_msgs import msg

from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_client.runs.shipped import shipped
from hitab_ros import names, qos
from hitab_ros.presence import ROSTERS

SECONDS = 60.0
IDLE_STATUSES = 4  # of the world, which sends one a second
HOSTS = 2
ENDPOINTS_OF_A_HOST = 16
"""Whatever the number of its agents and commanders."""
CYCLES = 30  # of play, in which each process gives several signs of life


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


@pytest.mark.parametrize("agents", [100, pytest.param(1000, marks=pytest.mark.long)])
def test_what_does_not_change_costs_no_message_and_who_is_not_asked_has_no_endpoint(
    home: Path, tmp_path: Path, agents: int
) -> None:
    with temporary_swarm(parse_swarm(description(agents), tmp_path / "idle.yaml")) as swarm:
        link, came, rosters = swarm.link, Counter[str](), []
        for name, kind in (("forager_1", "agent"), ("squad_1", "commander")):
            assert endpoints_of(swarm, name, kind) == 0
        link.subscribe(msg.HostRoster, f"/{names.HOSTS}", rosters.append, ROSTERS)
        assert link.spin_until(lambda: len(rosters) == HOSTS, SECONDS)
        for roster in rosters:
            assert endpoints_of(swarm, roster.host, "host") == ENDPOINTS_OF_A_HOST
            for kind, topic in ((msg.Reports, names.REPORTS), (msg.Orders, names.ORDERS)):
                link.subscribe(
                    kind,
                    f"/{roster.host}/{topic}",
                    lambda _, topic=topic: came.update([topic]),
                    qos.EVENTS,
                )
        for kind, topic, profile in (
            (msg.HostStatuses, f"/{names.STATUSES}", qos.STATUSES),
            (msg.Alive, f"/{names.ALIVE}", qos.SIGNS_OF_LIFE),
            (msg.WorldStatus, "/world/status", qos.LATCHED),
        ):
            link.subscribe(kind, topic, lambda _, topic=topic: came.update([topic]), profile)

        def idle() -> bool:
            """Note what comes during some seconds; return whether only the processes sent it."""
            came.clear()
            link.spin_until(lambda: came["/world/status"] >= IDLE_STATUSES, SECONDS)
            return came.keys() <= {"/alive", "/world/status"}

        assert link.spin_until(idle, SECONDS), came
        # Two signs of life a second from each host and from the world.
        assert came["/alive"] <= 2 * (HOSTS + 1) * (IDLE_STATUSES + 1)


def test_what_does_not_change_while_a_swarm_plays_is_told_by_signs_of_life(
    home: Path, tmp_path: Path
) -> None:
    with temporary_swarm(parse_swarm(description(20), tmp_path / "idle.yaml")) as swarm:
        link, came, hosts = swarm.link, Counter[str](), set[str]()
        cycles, known = dict[str, int](), []

        def on_roster(roster: msg.HostRoster) -> None:
            hosts.add(roster.host)

        def on_sign(sign: msg.Alive) -> None:
            if sign.process in hosts:
                cycles[sign.process] = sign.cycle

        link.subscribe(msg.HostRoster, f"/{names.HOSTS}", on_roster, ROSTERS)
        link.subscribe(msg.Alive, f"/{names.ALIVE}", on_sign, qos.SIGNS_OF_LIFE)
        assert link.spin_until(lambda: len(hosts) == HOSTS, SECONDS)
        receivers = [*hosts, *swarm.record.commanders]
        for name in receivers:
            for kind, topic in ((msg.Reports, names.REPORTS), (msg.Orders, names.ORDERS)):
                link.subscribe(
                    kind,
                    f"/{name}/{topic}",
                    lambda _, topic=topic: came.update([topic]),
                    qos.EVENTS,
                )
        link.subscribe(msg.CommanderStatus, "/squad_1/group", known.append, qos.LATCHED)
        swarm.world.control("resume")
        assert link.spin_until(lambda: len(cycles) == HOSTS and min(cycles.values()) > 0, SECONDS)
        assert link.spin_until(
            lambda: known and not any(member.silent for member in known[-1].subordinates), SECONDS
        )
        came.clear()
        until = min(cycles.values()) + CYCLES
        assert link.spin_until(lambda: min(cycles.values()) >= until, SECONDS)
        assert not came
        assert not any(member.silent for member in known[-1].subordinates)
