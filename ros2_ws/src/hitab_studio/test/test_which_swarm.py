"""The studio acts on the swarm that is meant, or not at all."""

import asyncio
import contextlib

import pytest

from hitab_client.errors import SwarmError
from hitab_client.run_folder import RunFolder, RunRecord
from hitab_studio import finding
from hitab_studio.finding import Target, find_target
from hitab_studio.swarm_link import SwarmLink


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path / "home"))
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)


def test_while_it_is_not_certain_which_swarm_is_meant_nothing_is_done():
    # It used to connect to ROS domain 0, whoever was there.
    done: list[object] = []

    async def ask(link: SwarmLink) -> None:
        await asyncio.wait_for(link.do(done.append), 30.0)

    link = SwarmLink(lambda: Target(0, problem="Which one?"), lambda _: None)
    link.start()
    with contextlib.ExitStack() as stack:
        stack.callback(link.stop)
        with pytest.raises(SwarmError, match=r"Which one\?"):
            asyncio.run(ask(link))
    assert done == []


def test_a_swarm_that_is_not_up_is_a_problem_and_not_whatever_is_there(tmp_path):
    assert 'Swarm "red" is not up.' in find_target("red").problem
    assert f"No swarm is up in {tmp_path}" in find_target(None, tmp_path).problem
    assert find_target() == Target(0)


def test_a_target_has_the_identity_of_its_run_folder(tmp_path, monkeypatch):
    folder = RunFolder(tmp_path)
    folder.prepare()
    record = RunRecord("red", "r.yaml", 7, "LOCALHOST", ("a",), True, 1, "s", "red-0a1b2c3d")
    folder.write(record, register=False)
    monkeypatch.setattr(finding.RunFolder, "supervisor", lambda *_: object())
    target = find_target(None, tmp_path)
    assert (target.identity, target.world, target.domain_id) == ("red-0a1b2c3d", True, 7)
