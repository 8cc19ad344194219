"""A swarm is started and stopped from the page; what goes wrong is said there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from browsing import ONE, Person, needs_browser, studio
from keepers import trained_keepers

from hitab_bringup.processes.bringing_up import temporary_swarm
from hitab_client import domain_ids
from hitab_client.runs.run_folder import running_swarms


@pytest.fixture
def someone(chrome: Any, home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    # In a domain of their own: the page would show whatever swarm somebody has started by hand.
    with domain_ids.reserved() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        yield from _someone(chrome, tmp_path)


def _someone(chrome: Any, tmp_path: Path) -> Any:
    with studio(tmp_path / "log") as address:
        page = chrome.new_page(viewport={"width": 1280, "height": 720})
        person = Person(page, address)
        yield person
        page.close()
        assert person.complaints == []


@needs_browser
def test_a_swarm_is_started_and_stopped_from_the_page(someone, hitab):
    page = someone.page
    try:
        page.wait_for_selector("text=No swarm is up")
        page.select_option('[data-test="swarm-choice"]', "keepaway")
        someone.click("swarm-start")
        someone.sees("launch", "Starting keepaway")
        for number in (1, 2, 3):
            someone.sees(f"agent-keeper_{number}")
        someone.sees_field()
        someone.does_not_see("launch")
        assert [record.swarm for _, record in running_swarms()] == ["keepaway"]
        someone.click("tab-swarm")
        someone.click("swarm-stop")
        someone.click("stop-now")
        someone.waits_until(lambda: not list(running_swarms()), "it is down", 60.0)
        someone.does_not_see("launch")
    finally:
        hitab("down", "keepaway")


@needs_browser
def test_a_page_stays_with_its_swarm_and_offers_the_others_to_click(
    chrome, home, tmp_path, monkeypatch
):
    """A second swarm took the first one from the page and left nothing to click."""
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    keepers = trained_keepers(None, "", {})
    alone = replace(keepers, agents=keepers.agents[:1])
    two_of_them = replace(keepers, agents=keepers.agents[:2])

    def listed(running: Any, name: str) -> None:
        running.folder.write(replace(running.record, swarm=name), register=True)

    with studio(tmp_path / "log") as address:
        page = chrome.new_page(viewport={"width": 1280, "height": 720})
        someone = Person(page, address)
        with temporary_swarm(alone, tmp_path / "red") as red:
            listed(red, "red")
            someone.sees_field()
            someone.click(f"agent-{ONE}")
            with temporary_swarm(two_of_them, tmp_path / "blue") as blue:
                listed(blue, "blue")
                someone.click("tab-swarm")
                someone.sees("swarm-blue", "2 agents, since")
                someone.sees("agents-there", "1 agent")
                someone.sees("banner", ONE)
                someone.click("swarm-blue")
                someone.sees("agents-there", "2 agents")
                someone.does_not_see("banner")
                someone.sees_field()
            page.wait_for_selector("text=blue has ended")
            things = "() => window.studioField.roster.names.length"
            someone.waits_until(lambda: page.evaluate(things) == 0, "the field is empty")
            offered = someone.sees("swarm-red", "1 agent, since").bounding_box()
            stage = page.locator("#stage").bounding_box()
            assert stage["x"] <= offered["x"]
            assert offered["x"] + offered["width"] <= stage["x"] + stage["width"]
            someone.click("swarm-red")
            someone.sees("agents-there", "1 agent")
            someone.sees_field()
        assert someone.complaints == []
        page.close()
