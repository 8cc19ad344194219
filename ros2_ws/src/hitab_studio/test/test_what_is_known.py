"""The page shows the known state of a swarm that starts, is slow or has ended."""

import asyncio
import time
from collections.abc import Callable
from typing import Any

import pytest
from hitab_msgs.msg import AgentStatus, WorldStatus

from hitab_client import SwarmError
from hitab_ros import KnownStops
from hitab_ros.timing import ANSWER_S
from hitab_studio.actions import REGISTERED_ACTIONS
from hitab_studio.pages.page import Page
from hitab_studio.pages.page_view import perform
from hitab_studio.studio import Studio
from hitab_studio.swarm.swarm_finder import SwarmTarget
from hitab_studio.swarm.swarm_state import SwarmState
from hitab_studio.views import render
from hitab_studio.views.side import TABS

ONE = "keeper_1"
UP = SwarmTarget(0, "keepaway", (ONE, "keeper_2"), 1, folder="/keepaway", world=True)
OVER = SwarmTarget(0, problem="keepaway has ended. Another swarm is up. Choose the one to show:")


def shown(known: SwarmState, *panels: str, tab: str = "teach", agent: str = ONE) -> str:
    """Return the text of panels of a page."""

    async def made() -> str:
        page = Studio(lambda: SwarmTarget(0)).open()
        page.studio.known = known
        page.agent, page.tab = agent, tab
        return "".join(render(panel, page) for panel in panels)

    return asyncio.run(made())


def hears(*names: str) -> dict[str, Any]:
    return {name: AgentStatus(agent=name, mode="idle") for name in names}


# -- a swarm that has ended -------------------------------------------------------------------


@pytest.mark.parametrize("tab", [tab for tab in TABS if tab not in ("swarm", "record")])
def test_nothing_is_said_of_an_agent_whose_swarm_has_ended(tab):
    said = shown(SwarmState(OVER), "overlay", "side", tab=tab)
    assert "is empty" not in said
    assert "Nothing" not in said
    assert "No training" not in said
    assert "is not known until it answers" in said
    assert f'{ONE}</b> <span class="soft" data-test="absent">is not up' in said
    assert "when its swarm is up again" in said
    assert "does not answer" not in said


def in_a_studio(term: Callable[[Studio, Page], None]) -> None:
    async def made() -> None:
        studio = Studio(lambda: SwarmTarget(0))
        page = studio.open()
        studio.take(SwarmState(UP, 1, statuses=hears(ONE)))
        term(studio, page)

    asyncio.run(made())


def test_a_dialog_about_a_swarm_closes_when_that_ends_and_the_page_says_so():
    def term(studio: Studio, page: Page) -> None:
        page.dialog = {"kind": "distribute", "name": "Chase", "agent": ONE}
        studio.take(SwarmState(UP, 2, statuses=hears(ONE, "keeper_2")))
        assert page.dialog, "its swarm is there"
        studio.take(SwarmState(OVER, 3))
        assert "dialog" not in render("dialog", page)
        closed = "The dialog was closed: keepaway is not there any more."
        assert closed in render("messages", page)
        studio.take(SwarmState(UP, 4, statuses=hears(ONE)))
        assert closed not in render("messages", page), "it is there again"
        page.dialog = {"kind": "help"}
        studio.take(SwarmState(UP, 4))
        assert page.dialog, "it is about no swarm"

    in_a_studio(term)


def test_a_refusal_is_shown_in_the_dialog_that_asked_for_it():
    async def refuses(page: Page, data: Any) -> None:
        raise SwarmError("Choose at least one feature.")

    async def nothing(page: Page, data: Any) -> None: ...

    async def made(monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setitem(REGISTERED_ACTIONS, "refuses", refuses)
        monkeypatch.setitem(REGISTERED_ACTIONS, "nothing", nothing)
        page = Studio(lambda: SwarmTarget(0)).open()
        page.studio.known = SwarmState(UP, statuses=hears(ONE))
        page.agent = ONE
        new = {"kind": "new", "agent": ONE, "resume": "", "name": "", "parameter": ""}
        caution = {"kind": "caution", "agent": ONE}
        rename = {"kind": "rename-recording", "name": "a"}
        for dialog in (new, caution, rename, {"kind": "snapshots"}):
            page.dialog = dict(dialog)
            await perform(page, {"do": "refuses"})
            assert "Choose at least one feature." in render("dialog", page)
            assert "Choose" not in render("messages", page)
            await perform(page, {"do": "why", "reason": "It is not ready."})
            assert "It is not ready." in render("dialog", page)
            await perform(page, {"do": "nothing"})
            assert 'data-test="refused"' not in render("dialog", page)
        page.close_dialog()
        await perform(page, {"do": "refuses"})
        assert "Choose at least one feature." in render("messages", page)

    with pytest.MonkeyPatch.context() as monkeypatch:
        asyncio.run(made(monkeypatch))


# -- a swarm that starts ----------------------------------------------------------------------


def test_agents_that_were_not_heard_yet_are_waited_for_while_others_come():
    target = SwarmTarget(0, "thousand", tuple(f"forager_{i}" for i in range(1000)), 1, world=True)
    coming = SwarmState(target, joined=time.monotonic(), world=WorldStatus(mode="running"))
    said = shown(coming, "top", "agents", "side", tab="swarm", agent="")
    assert "0 of 1000 agents, waiting to hear from them" in said
    assert "Waiting to hear from 1000 agents" in said
    assert "No agent" not in said
    said = shown(coming, "agents", "overlay", agent="forager_1")
    assert "no answer" not in said.lower()
    assert "has not been heard yet" in said
    late = SwarmState(target, joined=time.monotonic() - ANSWER_S - 1, world=WorldStatus())
    assert "No agent answers" in shown(late, "side", tab="swarm", agent="")
    assert "No answer" in shown(late, "overlay", agent="forager_1")
    some = SwarmState(UP, statuses=hears(ONE), joined=time.monotonic(), world=WorldStatus())
    assert "1 of 2 agents, waiting for the others" in shown(some, "top")
    both = SwarmState(UP, statuses=hears(ONE, "keeper_2"), joined=time.monotonic())
    assert not both.is_waiting


# -- out of reach -----------------------------------------------------------------------------


def test_groups_that_halt_out_of_reach_are_named_and_who_is_out_of_reach_once_for_all():
    lost = "squad is out of reach: silent since 14:03:05"
    statuses = hears("ant_1", "ant_2", "lone", "squad")
    for name in ("ant_1", "ant_2"):
        statuses[name].order.commander = "squad"
        statuses[name].when_out_of_reach, statuses[name].last_error = "halt", lost
    said = shown(SwarmState(UP, statuses=statuses), "side", tab="swarm", agent="")
    assert "halt when out of reach: squad (2 agents)" in said
    assert f"ant_1, ant_2: {lost}" in said
    statuses["ant_2"].when_out_of_reach = "go_on"
    said = shown(SwarmState(UP, statuses=statuses), "side", tab="swarm", agent="")
    assert "halt when out of reach: ant_1<" in said


# -- the emergency stop -----------------------------------------------------------------------


def test_the_emergency_stop_is_large_where_robots_may_do_harm_and_when_it_is_engaged():
    status = hears(ONE)
    assert "large" in shown(SwarmState(UP, statuses=status), "emergency")
    assert "large" not in shown(SwarmState(UP, statuses=status, world=WorldStatus()), "emergency")
    assert "large" not in shown(SwarmState(UP), "emergency")
    stop = KnownStops().stopped("1", "Anna", "a dog")
    said = shown(SwarmState(UP, world=WorldStatus(), emergency=stop), "emergency", "top")
    assert "large" in said
    assert 'data-test="release"' in said
    assert "stopped by Anna (a dog)" in said
    released = stop.released_by("Ben")
    assert 'data-test="stop-robots"' in shown(SwarmState(UP, emergency=released), "emergency")


# -- a swarm that is slow ---------------------------------------------------------------------


def test_a_world_whose_cycles_come_is_not_silent_even_if_its_signs_of_life_do_not(stand_in):
    async def term(studio: Studio) -> None:
        stand_in.alive = ("world", "nobody")
        deadline = time.monotonic() + 60.0
        while (observer := studio.link._observer) is None or len(observer._signs.last_signs) < 2:
            assert time.monotonic() < deadline, "the signs are heard"
            await asyncio.sleep(0.01)
        stand_in.alive = ()
        while "nobody" not in studio.known.silent:
            assert time.monotonic() < deadline, "what sends nothing else falls silent"
            await asyncio.sleep(0.01)
        assert "world" not in studio.known.silent

    async def run() -> None:
        studio = Studio(lambda: stand_in.target)
        await studio.start()
        try:
            await term(studio)
        finally:
            await studio.stop()

    asyncio.run(asyncio.wait_for(run(), 100.0))
