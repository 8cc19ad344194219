"""What was trained today can be run tomorrow, also if a file was damaged overnight."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from hitab_client import RosLink, SwarmClient
from hitab_client.runs.run_folder import running_swarms
from hitab_core.operations import BeginTraining, Command, SaveBehavior

SOCCER = """\
swarm: soccer
world: {kind: keepaway, pace: lockstep, paused: true}
domain: keepaway
hosts: 1
agents: {keeper_1: {}, keeper_2: {}, keeper_3: {}}
"""
TODAY = SOCCER + "behavior: Wander\n"


@pytest.fixture
def description(apart: Path) -> str:
    """Return a description in a folder of the test's own."""
    (path := apart / "soccer.yaml").write_text(SOCCER)
    return str(path)


def done(hitab: Callable, *arguments: str) -> str:
    result = hitab(*arguments)
    assert result.returncode == 0, result.stderr
    return result.stdout


def train(name: str) -> None:
    """Train keeper_1 to stand and to go fast, in turn."""
    ((_, record),) = running_swarms()
    with RosLink(record.domain_id) as link:
        agents = SwarmClient(link, record.agents, identity=record.identity)
        agents.do("keeper_1", BeginTraining(name, features=["Done"]))
        agents.do("keeper_1", Command("Stop"))
        agents.do("keeper_1", Command("GoFast"))
        agents.do("keeper_1", SaveBehavior())


def status(hitab: Callable) -> dict[str, dict]:
    return {a["agent"]: a for a in json.loads(done(hitab, "status", "--json", "-"))["agents"]}


def test_a_library_that_is_named_serves_all_agents_the_next_day(
    hitab: Callable, description: str, tmp_path: Path
) -> None:
    first = hitab("up", description, "--library", "ours")
    assert first.stderr.count("ours is a new library: nothing is learned in it yet") == 1
    train("Wander")
    assert "keeper_2: 1 trained behavior" in done(hitab, "library", "reload", "keeper_2")
    done(hitab, "down")
    assert (tmp_path / "ours" / "Wander.hfa.yaml").exists()
    Path(description).write_text(TODAY.replace("paused: true", "paused: false"))
    up = hitab("up", description, "--library", "ours")
    assert "a new library" not in up.stderr
    assert "the world is still paused" in up.stderr
    assert {a["behavior"] for a in status(hitab).values()} == {"Wander"}
    assert "Wander" in done(hitab, "library", "list")


def test_a_swarm_is_up_with_a_damaged_library_and_says_what_it_lost(
    hitab: Callable, description: str, tmp_path: Path
) -> None:
    done(hitab, "up", description, "--library", "ours")
    train("Wander")
    done(hitab, "down")
    path = tmp_path / "ours" / "Wander.hfa.yaml"
    path.write_bytes(path.read_bytes()[:700])
    Path(description).write_text(TODAY)
    up = hitab("up", description, "--library", "ours")
    assert up.returncode == 0, up.stderr
    assert "keeper_1, keeper_2, keeper_3: Wander is lost: its file in " in up.stderr
    agents = status(hitab)
    assert {a["mode"] for a in agents.values()} == {"idle"}
    assert all("Wander.hfa.yaml" in a["faults"][0] for a in agents.values())
    text = " ".join(done(hitab, "status").split())
    assert text.count("keeper_1, keeper_2, keeper_3: Wander is lost") == 1
    refused = hitab("perform", "keeper_1", "Wander")
    assert refused.returncode == 1
    assert "Wander is lost" in refused.stderr
    done(hitab, "library", "restore", "Wander", "1")
    told = done(hitab, "library", "reload")
    assert "keeper_1, keeper_2, keeper_3: 1 trained behavior" in told
    agents = status(hitab)
    assert {a["behavior"] for a in agents.values()} == {"Wander"}
    assert [a["faults"] for a in agents.values()] == [[], [], []]
    done(hitab, "library", "delete", "Wander")
    refused = hitab("library", "reload")
    assert refused.returncode == 1
    assert (
        "keeper_1, keeper_2, keeper_3: it keeps its present library: it could no" in refused.stderr
    )
