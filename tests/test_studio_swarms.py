"""A swarm is started and stopped from the page; what goes wrong is said there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from browsing import Person, needs_browser, studio

from hitab_client import domain_ids
from hitab_client.run_folder import running_swarms


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
def test_a_start_that_fails_says_why_until_it_is_closed(someone, home):
    someone.page.wait_for_selector("text=No swarm is up")
    # A folder where the swarm would keep its files cannot be made.
    (home / "keepaway_predictive").mkdir()
    (home / "keepaway_predictive" / "logs").write_text("a file is in the way")
    someone.page.select_option('[data-test="swarm-choice"]', "keepaway_predictive")
    someone.click("swarm-start")
    failed = someone.sees("launch-failed", "keepaway_predictive did not start")
    assert "cannot be made" in failed.inner_text()
    someone.click("launch-dismiss")
    someone.does_not_see("launch-failed")
    someone.sees("swarm-start")
