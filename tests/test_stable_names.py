"""Names in the ROS graph are the same in each run, so that a security policy can list them."""

import os
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from hitab_client import RosLink

SECONDS = 60.0
TOPICS_PAGE = Path(__file__).parents[1] / "docs" / "topics.md"

# An agent in a process of its own, and another one and a commander in a shared one.
SWARM = """\
swarm: mixed
domain: keepaway
world: {kind: keepaway, pace: lockstep, paused: true, parameters: {keepers: 2}}
agents:
  keeper_1: {}
  keeper_2: {host: pair}
kinds:
  Captain: {orders: {Halt: Stop}}
commanders:
  captain: {kind: Captain, commands: [keeper_1, keeper_2], host: pair}
"""
NODES = {
    "/world/world",
    "/keeper_1/agent",
    "/keeper_2/agent",
    "/captain/commander",
    "/host",
    "/host_of_keeper_2/host",
    "/hitab",
}
OWNERS = {name.split("/")[1] for name in NODES}

OF_ROS = (
    r"(describe|get|list|set)_parameters(_atomically)?|get_parameter_types|get_type_description"
)
"""Services that ROS adds to nodes."""


def graph(link: RosLink) -> set[str]:
    """Return what is there beside the link: nodes, topics with types, and services with types."""
    nodes = link.node.get_node_names_and_namespaces()
    topics = link.node.get_topic_names_and_types()
    services = link.node.get_service_names_and_types()
    return {
        *(f"node {space.rstrip('/')}/{name}" for name, space in nodes if name != "observer"),
        *(f"topic {name} {kind}" for name, kinds in topics for kind in kinds),
        *(f"service {name} {kind}" for name, kinds in services for kind in kinds),
    }


def documented(heading: str) -> set[str]:
    """Return the names of topics or services in the tables of docs/topics.md."""
    rows = re.split(rf"^\| {heading} .*\n", TOPICS_PAGE.read_text(), flags=re.MULTILINE)[1:]
    tables = [re.split(r"^(?!\|)", rest, maxsplit=1, flags=re.MULTILINE)[0] for rest in rows]
    return {name for table in tables for name in re.findall(r"^\| `([^`]+)`", table, re.MULTILINE)}


def in_docs(name: str) -> str:
    """Return a full name as docs/topics.md has it: relative to its agent, or to the swarm."""
    owner, _, own = name.removeprefix("/").partition("/")
    if owner.startswith("host_of_"):
        return f"<host>/{own}"
    if owner == "world" and own != "status":
        return f"world/{own}"
    return own if owner in OWNERS and own else name


def names_of(seen: set[str], what: str) -> set[str]:
    return {entry.split()[1] for entry in seen if entry.split()[0] == what}


def test_a_swarm_has_the_nodes_topics_and_services_of_the_docs_and_no_others(apart, hitab):
    path = apart / "mixed.yaml"
    path.write_text(SWARM)
    seen: set[str] = set()
    with (
        RosLink(int(os.environ["ROS_DOMAIN_ID"]), name="observer") as link,
        ThreadPoolExecutor() as pool,
    ):
        up = pool.submit(hitab, "up", str(path))

        def all_seen() -> bool:
            seen.update(graph(link))
            return up.done() and names_of(seen, "node") >= NODES

        assert link.spin_until(all_seen, 2 * SECONDS), sorted(seen)
    assert up.result().returncode == 0, up.result().stderr
    assert names_of(seen, "node") == NODES

    topics, services = documented("topic"), documented("service")
    assert {"status", "hosts", "world/state", "/clock"} <= topics
    of_swarm = {f"/{name}" for name in topics}
    there = {in_docs(name) for name in names_of(seen, "topic")}
    assert there - topics - of_swarm == {"/parameter_events", "/rosout"}
    of_node = re.compile(rf"({'|'.join(NODES)})/({OF_ROS})")
    offered = {name for name in names_of(seen, "service") if not of_node.fullmatch(name)}
    assert "/keeper_1/save_behavior" in offered
    assert {in_docs(name) for name in offered} - services == set()
