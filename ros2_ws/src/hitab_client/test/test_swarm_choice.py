"""Swarms are distinguished where several are meant."""

from dataclasses import replace
from pathlib import Path

import pytest

from hitab_client import swarm_choice
from hitab_client.errors import SwarmError
from hitab_client.runs.run_folder import RunFolder, RunRecord
from hitab_core import Fix

RED = RunRecord("red", "r.yaml", 3, "LOCALHOST", ("a",), True, 1, "s", "red-0a1b2c3d")
ANOTHER_RED = replace(RED, domain_id=4, identity="red-12345678")
BLUE = replace(RED, swarm="blue", domain_id=5, identity="blue-0a1b2c3d")


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch) -> Path:
    monkeypatch.setenv("HITAB_HOME", str(tmp_path / "home"))
    return tmp_path


def registered(path: Path, record: RunRecord) -> None:
    folder = RunFolder(path)
    folder.prepare()
    folder.write(record, register=True)


@pytest.fixture
def three(home: Path, monkeypatch) -> None:
    """Two swarms of one name, and a third."""
    for name, record in (("one", RED), ("two", ANOTHER_RED), ("three", BLUE)):
        registered(home / name, record)
    monkeypatch.setattr(RunFolder, "supervisor", lambda *_: object())


def test_only_swarms_that_match_are_offered_with_what_tells_them_apart(three, home):
    with pytest.raises(SwarmError) as refused:
        swarm_choice.find_running("red")
    first, *lines = str(refused.value).splitlines()
    assert first == 'several swarms called "red" are up; choose one with --swarm NAME:'
    for line, record, name in zip(lines, (RED, ANOTHER_RED), ("one", "two"), strict=True):
        assert line == f"  {record.identity}: ROS domain {record.domain_id}, {home / name}"
    found = swarm_choice.find_running(ANOTHER_RED.identity)
    assert found is not None
    assert found[1] == ANOTHER_RED


def test_what_messages_offer_chooses_one_swarm(three):
    for record in (RED, ANOTHER_RED, BLUE):
        found = swarm_choice.find_running(swarm_choice.name_to_choose(record))
        assert found is not None
        assert found[1] == record
    assert swarm_choice.name_to_choose(BLUE) == "blue", "short where it can be"
    one = RunFolder.of_swarm("red")
    assert swarm_choice.way_to_stop(one, RED) == Fix.DOWN(swarm=RED.identity)
