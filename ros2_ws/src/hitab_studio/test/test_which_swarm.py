"""The studio acts on the chosen swarm, or not at all."""

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Any

import pytest

from hitab_client import domain_ids
from hitab_client.connecting.identity import STARTED_BY_HAND
from hitab_client.errors import SwarmError
from hitab_client.runs.run_folder import RunFolder, RunRecord
from hitab_core.operations import Perform
from hitab_studio.pages.page_view import perform
from hitab_studio.studio import Studio
from hitab_studio.swarm import swarm_finder
from hitab_studio.swarm.swarm_finder import Finder, SwarmTarget
from hitab_studio.swarm.swarm_link import SwarmLink
from hitab_studio.views import render

ELSEWHERE = "keepaway-0a1b2c3d"


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path / "home"))
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)


def test_while_it_is_not_certain_which_swarm_is_meant_nothing_is_done():
    # The studio must not connect to any swarm in ROS domain 0.
    done: list[object] = []

    async def ask() -> None:
        link = SwarmLink(
            lambda: SwarmTarget(0, problem="Which one?"), lambda _: None, lambda text, **_: None
        )
        link.start()
        try:
            await asyncio.wait_for(link.ask(done.append), 30.0)
        finally:
            await link.stop()

    with pytest.raises(SwarmError, match=r"Which one\?"):
        asyncio.run(ask())
    assert done == []


async def its_link(swarm: Any) -> Any:
    return swarm.link


def test_a_studio_that_was_suspended_until_it_was_forgotten_connects_anew():
    async def reconnected() -> bool:
        with domain_ids.reserved() as number:
            target = SwarmTarget(number, identity=STARTED_BY_HAND)
            link = SwarmLink(lambda: target, lambda _: None, lambda text, **_: None)
            link.start()
            try:
                first = await link.ask(its_link)
                first._note_suspension(30.0)
                deadline = time.monotonic() + 60.0
                while time.monotonic() < deadline:
                    with contextlib.suppress(SwarmError):  # the studio is connecting
                        if await link.ask(its_link) is not first:
                            return True
                    await asyncio.sleep(0.05)
                return False
            finally:
                await link.stop()

    assert asyncio.run(reconnected())


def test_a_swarm_that_is_not_up_is_a_problem_and_not_whatever_is_there(tmp_path):
    assert 'Swarm "red" is not up.' in Finder("red")().problem
    assert f"No swarm is up in {tmp_path}" in Finder(None, tmp_path)().problem


def test_without_a_swarm_from_here_nodes_that_no_command_has_started_are_meant():
    assert Finder()() == SwarmTarget(0, identity=STARTED_BY_HAND)


def test_a_swarm_that_was_started_elsewhere_is_meant_if_its_identity_is_given():
    assert Finder(ELSEWHERE)() == SwarmTarget(0, ELSEWHERE, identity=ELSEWHERE)


def test_nodes_that_no_command_has_started_are_meant_in_the_namespace_that_is_given():
    assert Finder("/red")() == SwarmTarget(0, identity=STARTED_BY_HAND, namespace="/red")


@pytest.fixture
def ups(tmp_path, monkeypatch):
    """Return a function that sets the running swarms, by the names of their folders."""

    def up(*names: str) -> None:
        found = []
        for name in names:
            folder = RunFolder(tmp_path / name)
            record = RunRecord(name, "y", 7, "LOCALHOST", ("a",), True, 1, "s", f"{name}-0a1b2c3d")
            found.append((folder, record))
        monkeypatch.setattr(swarm_finder, "running_swarms", lambda: iter(found))

    return up


def test_a_studio_stays_with_its_swarm_whatever_else_starts(ups):
    find = Finder()
    ups("red")
    assert find().swarm == "red"
    ups("blue", "red")
    assert find().swarm == "red"
    assert [choice.swarm for choice in find().choices] == ["blue", "red"]
    ups("blue")
    assert "red has ended. Another swarm is up" in find().problem, "red may come back"
    ups("blue", "red")
    assert find().swarm == "red"
    ups()
    assert find() == SwarmTarget(0, identity=STARTED_BY_HAND)
    ups("blue")
    assert find().swarm == "blue"


def test_among_several_swarms_the_one_that_was_chosen_is_remembered(ups, tmp_path):
    find = Finder()
    ups("blue", "red")
    target = find()
    assert "Several swarms are up" in target.problem
    assert [(c.swarm, c.agents) for c in target.choices] == [("blue", ("a",)), ("red", ("a",))]
    find.choose(target.choices[1].folder)
    assert find().swarm == "red"
    ups("blue", "green", "red")
    assert find().swarm == "red"


def test_swarms_in_other_domains_are_not_offered_if_a_domain_is_given(ups, monkeypatch):
    ups("blue", "red")
    monkeypatch.setenv("ROS_DOMAIN_ID", "8")
    assert Finder()() == SwarmTarget(8, identity=STARTED_BY_HAND)


def in_a_studio(
    find: Callable[[], SwarmTarget],
    term: Callable[[Studio], Awaitable[None]],
    choose: Callable[[str], None] = lambda folder: None,
) -> None:
    async def run() -> None:
        studio = Studio(find, choose=choose)
        await studio.start()
        try:
            await term(studio)
        finally:
            await studio.stop()

    asyncio.run(asyncio.wait_for(run(), 100.0))


async def until(true: Callable[[], Any], what: str) -> None:
    deadline = time.monotonic() + 60.0
    while not true():
        assert time.monotonic() < deadline, what
        await asyncio.sleep(0.01)


@pytest.fixture
def nodes(stand_in) -> SwarmTarget:
    return replace(stand_in.target, swarm="", agents=(), start=0, identity=STARTED_BY_HAND)


def test_a_swarm_that_was_started_elsewhere_is_left_alone_and_how_to_use_it_is_said(
    stand_in, nodes
):
    stand_in.belong_to(ELSEWHERE)

    async def term(studio: Studio) -> None:
        page = studio.open()
        await until(lambda: studio.known.elsewhere == (ELSEWHERE,), "it is noticed")
        await until(lambda: studio.known.scene is None, "its world is not shown")
        assert not studio.known.statuses
        assert f"hitab studio {ELSEWHERE}" in render("overlay", page)
        for ask in (
            lambda swarm: swarm.agents.do.coroutine("keeper_1", Perform()),
            lambda swarm: swarm.world.control.coroutine("pause"),
        ):
            with pytest.raises(SwarmError, match=f"{ELSEWHERE}, which was not started from here"):
                await page.ask(ask)

    in_a_studio(lambda: nodes, term)


@pytest.mark.parametrize("identity", [ELSEWHERE, ""])
def test_whom_no_command_has_started_or_who_was_named_is_shown(stand_in, nodes, identity):
    stand_in.belong_to(identity)

    async def term(studio: Studio) -> None:
        await until(lambda: len(studio.known.statuses) == 2, "its agents")
        await until(lambda: studio.known.scene, "its world")
        assert studio.known.elsewhere == ()

    in_a_studio(lambda: replace(nodes, identity=identity or STARTED_BY_HAND), term)


def test_nodes_started_by_hand_stay_until_they_have_gone_or_another_swarm_is_chosen(
    stand_in, nodes
):
    stand_in.belong_to("")
    choice = SwarmTarget(0, "red", ("keeper_1",), folder="/red")
    targets = [replace(nodes, identity=STARTED_BY_HAND)]
    chosen = []

    async def term(studio: Studio) -> None:
        await until(lambda: studio.known.scene, "its world")
        targets.append(
            SwarmTarget(nodes.domain_id, "red", ("a",), 1, "", "red-0", choices=(choice,))
        )
        await until(lambda: studio.known.target.choices == (choice,), "it is offered")
        assert studio.known.scene is not None
        page = studio.open()
        page.choose(["keeper_1"])
        page.look_at("keeper_1")
        await perform(page, {"do": "swarm-choose", "name": "/red"})
        await until(lambda: studio.known.target.swarm == "red", "it is shown")
        assert chosen == ["/red"]
        assert (page.agent, page.chosen) == ("", [])
        # A world's state may arrive before the world's identity.
        await until(lambda: not studio.present.frame, "no other world is shown")
        assert studio.known.agents == ("a",)

    in_a_studio(lambda: targets[-1], term, chosen.append)
