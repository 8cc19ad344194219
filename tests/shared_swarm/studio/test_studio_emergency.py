"""The emergency stop on the page: always reachable, and everybody sees who has engaged it."""

from __future__ import annotations

from typing import Any

import pytest
from browsing import ONE, Person, needs_browser

from hitab_ros import EmergencySwitch


@pytest.fixture
def switch(swarm):
    """Somebody else's emergency stop, released at the end."""
    made = EmergencySwitch(swarm.link.node)
    yield made
    if made.engaged:
        made.set(False, "the test")


@needs_browser
def test_one_key_stops_all_robots_wherever_the_focus_is_and_releasing_asks(swarm, person, switch):
    person.click(f"agent-{ONE}")
    person.click("new")
    person.sees("new-name")
    person.page.focus('[data-test="new-name"]')
    person.page.keyboard.press("Control+Enter")
    person.waits_until(lambda: swarm.link.spin(0.02) or switch.engaged, "stopped")
    assert switch.known.who.endswith("(emergency stop in the studio)")
    person.sees("stopped", f"stopped by {switch.known.who}")
    assert person.page.locator('[data-test="new-name"]').count() == 1, "the form stays"
    person.click("release")  # in front of the dialog, too
    person.sees("release-dialog")
    person.click("release-not")
    person.does_not_see("release-dialog")
    assert switch.engaged
    person.click("release")
    person.click("release-now")
    person.waits_until(lambda: swarm.link.spin(0.02) or not switch.engaged, "released")
    person.does_not_see("stopped")


@needs_browser
def test_a_stop_by_others_is_seen_by_all_with_its_reason(swarm, person, chrome, url, switch):
    switch.set(True, "Anna", "a dog on the field")
    person.sees("stopped", "stopped by Anna (a dog on the field)")
    page = chrome.new_page(viewport={"width": 820, "height": 1180})
    late = Person(page, url)
    late.sees("stopped", "stopped by Anna")
    switch.set(False, "Anna")
    person.does_not_see("stopped")
    person.click("stop-robots")
    late.sees("stopped")
    page.close()
    person.click("release")
    person.click("release-now")
    person.does_not_see("stopped")
    person.waits_until(lambda: swarm.link.spin(0.02) or not switch.engaged, "released")


@needs_browser
def test_a_stop_that_is_not_answered_is_sent_again_after_a_reload_too(swarm, person, switch):
    """In a test, the page made its connection anew just then, and the stop was lost."""
    lost: list[str] = []

    def lose(route: Any) -> None:
        lost.append(route.request.url)
        route.abort()

    person.page.route("**/stop-robots*", lose)
    person.page.keyboard.press("Control+Enter")
    person.sees("stop-report", "The studio has not answered yet")
    person.waits_until(lambda: len(lost) > 1, "it is sent again")
    person.page.reload()
    person.sees("stop-report", "The studio has not answered yet")
    assert not switch.engaged
    person.page.unroute("**/stop-robots*", lose)
    person.waits_until(lambda: swarm.link.spin(0.02) or switch.engaged, "stopped")
    person.sees("stopped")
    person.waits_until(lambda: not person.page.inner_text("#stop-report"), "it is stopped")
    person.complaints.clear()  # of the browser, about the requests that were lost
    switch.set(False, "the test")
    person.does_not_see("stopped")
