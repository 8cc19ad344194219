"""`hitab policy` allows what the nodes of a swarm do, as the ROS graph shows it, and no more.

ROS from wheels has no DDS security, so nothing enforces the policy here.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
import rclpy
from rclpy.context import Context
from waiting import within

from hitab_bringup import (
    RunningSwarm,
    SwarmDescription,
    parse_swarm,
    security_policy,
    temporary_swarm,
)
from hitab_studio.studio import Studio
from hitab_studio.swarm.swarm_finder import SwarmTarget

SWARM = """\
swarm: field
domain: foraging
world: {kind: foraging, parameters: {foragers: 3}}
start_from: foraging
behavior: Forage
agents:
  forager: {count: 3}
kinds: {Squad: {orders: {Work: Forage, Rest: nothing}}}
commanders:
  squad: {kind: Squad, commands: forager}
"""
HOSTS = "hosts: 2\n"
MACHINES = "machines: {lab_1: {runs: [world, squad]}}\n"

Names = dict[str, set[str]]
Rights = dict[tuple[str, str], tuple[str, Names]]
"""Enclave and names of each node, by namespace and name."""

READ = {
    "publish": "get_publisher_names_and_types_by_node",
    "subscribe": "get_subscriber_names_and_types_by_node",
    "reply": "get_service_names_and_types_by_node",
    "request": "get_client_names_and_types_by_node",
}
CONSOLES = {("/", "hitab"), ("/", "hitab_studio")}
ON_DEMAND = {
    # for a recorder; for members in other hosts; while agents move
    "publish": ("perceived", "orders", "reports", "hosts", "alive"),
    # of processes that were asked to wait for signs; while a process starts
    "subscribe": ("alive", "operators", "status", "hosts"),
}
"""Last parts of the names that a node uses only at times."""


def described(text: str, folder: Path) -> SwarmDescription:
    file = folder / "field.yaml"
    file.write_text(text)  # a machine's node reads it
    return parse_swarm(text, file)


def allowed(swarm: SwarmDescription) -> Rights:
    """Return what the XML of a policy allows."""
    policy = ElementTree.fromstring(security_policy(swarm))
    return {
        (profile.attrib["ns"], profile.attrib["node"]): (
            enclave.attrib["path"],
            {
                verb: {name.text or "" for name in profile.iterfind(f"*[@{verb}='ALLOW']/*")}
                for verb in READ
            },
        )
        for enclave in policy.iterfind("enclaves/enclave")
        for profile in enclave.iterfind("profiles/profile")
    }


def in_graph(observer: Any) -> Rights:
    """Return what the nodes do, as another node sees the ROS graph."""
    return {
        (space, name): (
            enclave,
            {
                verb: {one for one, _ in getattr(observer, read)(name, space)}
                for verb, read in READ.items()
            },
        )
        for name, space, enclave in observer.get_node_names_and_namespaces_with_enclaves()
        if name != observer.get_name()
    }


def beyond(rights: Rights, others: Rights) -> list[tuple[str, ...]]:
    """Return what some nodes may or do that the others do not."""
    nothing: Names = {verb: set() for verb in READ}
    return [
        (*node, verb, name)
        for node, (_, names) in sorted(rights.items())
        for verb in READ
        for name in sorted(names[verb] - others.get(node, ("", nothing))[1][verb])
    ]


@contextlib.contextmanager
def observer_of(running: RunningSwarm) -> Iterator[Any]:
    """Yield a node in the ROS domain of a swarm."""
    context = Context()
    rclpy.init(context=context, domain_id=running.record.domain_id)
    node = rclpy.create_node("observer", context=context)
    try:
        yield node
    finally:
        node.destroy_node()
        context.try_shutdown()


def use_the_studio(running: RunningSwarm, look: Callable[[], object]) -> None:
    """Call a function while the studio shows the swarm and views an agent."""

    async def run() -> None:
        target = SwarmTarget(
            running.record.domain_id, "field", running.record.agents, 1, world=True
        )
        studio = Studio(lambda: target)
        await studio.start()
        try:
            studio.open().look_at("forager_1")
            deadline = time.monotonic() + 60.0
            while "forager_1" not in studio.known.watched or studio.known.scene is None:
                assert time.monotonic() < deadline, "the studio shows the agent"
                await asyncio.sleep(0.05)
            await asyncio.to_thread(look)
        finally:
            await studio.stop()

    asyncio.run(run())


@pytest.mark.parametrize("more", ["", HOSTS, MACHINES], ids=["alone", "hosts", "machines"])
def test_the_policy_has_what_the_graph_has_and_no_more(more, tmp_path):
    swarm = described(SWARM + more, tmp_path)
    policy = allowed(swarm)
    here = swarm.on_machine("lab_1") if more == MACHINES else swarm
    with temporary_swarm(here) as running, observer_of(running) as observer:
        running.world.control("pause")

        def superfluous() -> list[tuple[str, ...]]:
            return [
                one
                for one in beyond(policy, in_graph(observer))
                if one[:2] not in CONSOLES
                and one[3].rpartition("/")[2] not in ON_DEMAND.get(one[2], ())
            ]

        def compare() -> None:
            within(60.0, lambda: in_graph(observer).keys() == policy.keys())
            assert within(60.0, lambda: not superfluous()), superfluous()
            graph = in_graph(observer)
            assert graph.keys() == policy.keys()
            assert not beyond(graph, policy)
            assert {node: enclave for node, (enclave, _) in graph.items()} == {
                node: enclave for node, (enclave, _) in policy.items()
            }

        use_the_studio(running, compare)


def test_a_host_may_run_on_each_machine_and_a_machine_read_the_files_of_the_others(tmp_path):
    machines = "machines: {lab_1: {runs: [world, squad]}, lab_2: {runs: forager_3}}\n"
    policy = allowed(described(SWARM + machines, tmp_path))
    host = policy["/host_of_forager_3_on_lab_1", "host"]
    assert host[0] == policy["/host_of_forager_3_on_lab_2", "host"][0] == "/field/lab_2_host_1"
    _, lab_1 = policy["/lab_1", "machine"]
    assert lab_1["request"] == {"/lab_2/read_files"}
    _, world = policy["/world", "world"]
    assert "/host_of_forager_3_on_lab_1/percept_pieces" in world["publish"]


def test_namespaces_and_remappings_change_the_names(tmp_path):
    text = SWARM.replace("forager: {count: 3}", "forager: {count: 3, remap: {status: /seen}}")
    policy = allowed(described(text, tmp_path).in_namespace("left"))
    enclave, forager = policy["/left/forager_1", "agent"]
    assert enclave == "/field_left/forager_1"
    assert "/seen" in forager["publish"]
    assert "/left/forager_1/status" not in forager["publish"]
    assert {"/left/alive", "/left/squad/reports", "/left/world/actions"} <= forager["publish"]
    _, world = policy["/left/world", "world"]
    assert "/left/clock" in world["publish"]
    assert "/clock" not in world["publish"]


def test_the_command_writes_what_sros2_reads(hitab, tmp_path):
    """The structure is that of policy.xsd in sros2."""
    file = tmp_path / "policy.xml"
    assert "wrote" in hitab("policy", "keepaway", "--output", str(file)).stdout
    policy = ElementTree.parse(file).getroot()
    assert (policy.tag, policy.attrib) == ("policy", {"version": "0.2.0"})
    (enclaves,) = policy
    assert enclaves.tag == "enclaves"
    paths = [enclave.attrib["path"] for enclave in enclaves]
    assert len(paths) == len({*paths}) == 6
    for profile in policy.iterfind("enclaves/enclave/profiles/profile"):
        assert profile.attrib.keys() == {"ns", "node"}
        for rules in profile:
            (verb,) = rules.attrib
            assert rules.tag == f"{'topic' if verb in ('publish', 'subscribe') else 'service'}s"
            assert {(one.tag, (one.text or "")[0]) for one in rules} == {(rules.tag[:-1], "/")}
    assert hitab("policy", "keepaway").stdout == file.read_text()
