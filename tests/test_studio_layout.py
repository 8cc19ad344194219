"""What is said longest on the page can be read in windows of 1280 and 1024 pixels."""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType, SimpleNamespace
from typing import Any

import pytest
from browsing import needs_browser
from hitab_msgs.msg import AgentStatus, WorldStatus

import hitab_studio
from hitab_studio.known import Known
from hitab_studio.launching import startable_swarms
from hitab_studio.studio import Studio
from hitab_studio.swarm_finder import Choice, Target
from hitab_studio.views import PANELS, render

STYLE = Path(hitab_studio.__file__).parent / "static" / "studio.css"
SIZES = ((1280, 800), (1024, 768))


LATE = MappingProxyType({f"forager_{n}": time.monotonic() for n in range(57)})
THOUSAND = tuple(f"forager_{n}" for n in range(1251))


def html(known: Known, agent: str = "") -> str:
    """Return the page as the server describes it."""
    session = Studio(lambda: Target(0), startable_swarms()).open()
    session.shared.store.known, session.agent = known, agent
    panels = {name: render(name, session) for name in PANELS}
    stage = f'<section id="stage"><div id="panel-overlay">{panels.pop("overlay")}</div></section>'
    parts = (f'<div id="panel-{name}">{text}</div>' for name, text in panels.items())
    return f'<div id="studio">{"".join(parts)}{stage}</div>'


@pytest.fixture(scope="module")
def blank(chrome: Any) -> Iterator[Any]:
    """Return a window that shows what it is given, without a studio."""
    page = chrome.new_page()
    yield page
    page.close()


def shows(page: Any, content: str, size: tuple[int, int]) -> None:
    """Show this in a window of this size."""
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.set_content(f"<style>{STYLE.read_text()}</style>{content}")


def box(page: Any, selector: str) -> Any:
    return page.locator(selector).first.bounding_box()


def cut(page: Any, selector: str) -> bool:
    """Return whether something of it is not seen."""
    return bool(
        page.eval_on_selector(
            selector,
            "e => e.scrollWidth > e.clientWidth || e.getBoundingClientRect().right > innerWidth",
        )
    )


def swarm(mode: str = "performing", **more: Any) -> Known:
    """Return what is known of a thousand agents: many are silent, and some were not heard."""
    statuses = {
        name: AgentStatus(
            agent=name, mode=mode, behavior="GotoObject", active_path=["ServoBall", "TurnToBall"]
        )
        for name in THOUSAND[:1200]
    }
    scene = SimpleNamespace(
        cycle=98765, episode=1234, episode_cycle=98765, note="", names=(), kinds=(), mode="running"
    )
    return Known(
        Target(0, "foraging_company_school", THOUSAND, 1, folder="/run", world=True),
        world=WorldStatus(
            world="foraging",
            mode="running",
            pace="realtime",
            factor=1.0,
            missing=THOUSAND[100:150],
        ),
        scene=scene,
        statuses=statuses,
        joined=time.monotonic() - 1000.0,
        **more,
    )


@needs_browser
@pytest.mark.parametrize("size", SIZES)
def test_the_bar_at_the_top_has_room_for_a_thousand_of_whom_many_are_silent(blank, size):
    shows(blank, html(swarm(silent=LATE)), size)
    assert blank.inner_text('[data-test="absent-silent"]') == "57 silent"
    parts = [".where", ".bar", ".when", ".bar.end"]
    for part in parts:
        assert not cut(blank, part), part
    boxes = [box(blank, part) for part in parts]
    for left, right in pairwise(boxes):
        assert left["x"] + left["width"] <= right["x"], "one line, and nothing on anything else"
    last = boxes[-1]["x"] + boxes[-1]["width"]
    assert last <= box(blank, "#panel-emergency")["x"]
    assert box(blank, ".top")["height"] < 80


@needs_browser
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("mode", ["training", "testing"])
def test_what_an_agent_does_is_read_while_it_is_trained_and_tested(blank, size, mode):
    """In a test, the buttons left room for its name alone."""
    shows(blank, html(swarm(mode), "forager_7"), size)
    assert not cut(blank, '[data-test="mode"]')
    who = box(blank, ".banner .who")
    state = box(blank, ".banner .crumb")
    assert state["x"] + state["width"] <= who["x"] + who["width"]
    tools = box(blank, ".banner .tools")
    banner = box(blank, ".banner")
    assert banner["x"] <= tools["x"]
    assert tools["x"] + tools["width"] <= banner["x"] + banner["width"]


@needs_browser
@pytest.mark.parametrize("size", SIZES)
def test_all_tabs_are_seen(blank, size):
    shows(blank, html(swarm("training"), "forager_7"), size)
    assert not cut(blank, ".tabs")
    assert not cut(blank, ".tabs button:last-child")


@needs_browser
@pytest.mark.parametrize("size", SIZES)
def test_swarms_to_choose_from_are_read_however_long_their_names_are(blank, size):
    name = "a_swarm_whose_name_is_as_long_as_that_of_nobody_else_" * 2
    choices = (Choice(name, "/a/folder/of/" + name, 0, 1251), Choice("red", "/red", 0, 3))
    shows(blank, html(Known(Target(0, problem="Which?", choices=choices))), size)
    for part in (".choices b", ".choices .folder"):
        assert not cut(blank, part), part
