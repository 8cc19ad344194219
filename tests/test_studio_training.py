"""Before and while people train, the page tells them what they need to know."""

from __future__ import annotations

import contextlib
import re

import pytest
from browsing import ONE, TWO, Person, away_from_everybody, needs_browser

from hitab_client.errors import SwarmError


@pytest.fixture(autouse=True)
def nothing_is_trained(swarm):
    """Give up what another test has left."""
    with contextlib.suppress(SwarmError):  # nothing was left
        swarm.agents.discard(ONE)


def begin(person: Person, name: str, *features: str) -> None:
    person.click(f"agent-{ONE}")
    person.click("new")
    person.type("new-name", name)
    for feature in features or ("DistanceTo(ball)",):
        person.tick(f"feature-{feature}")
    person.click("begin")
    person.sees("mode", "Training")


@needs_browser
def test_a_training_begun_by_mistake_is_left_by_esc(swarm, person):
    begin(person, "Mistake")
    person.page.keyboard.press("Escape")
    person.sees("mode", "Idle")
    person.sees("message", "discarded")


@needs_browser
def test_who_would_lose_examples_is_asked_once(swarm, person):
    away_from_everybody(swarm, 5.0)
    begin(person, "Dear")
    person.click("do-GoFast")
    person.sees("counts", "2 examples")
    person.page.keyboard.press("Escape")
    person.sees("discard-dialog", "2 examples")
    person.click("discard-keep")
    person.does_not_see("discard-dialog")
    person.sees("mode", "Training")
    person.click("discard")
    person.click("discard-now")
    person.sees("mode", "Idle")
    person.waits_until(
        lambda: swarm.link.spin(0.02) or not swarm.agents.statuses[ONE].examples, "given up"
    )


@needs_browser
def test_the_history_shows_what_undo_takes_back_and_redo_does_again(swarm, person):
    away_from_everybody(swarm, 5.0)
    begin(person, "Past")
    person.click("do-GoFast")
    person.sees("history", "Start → GoFast, 2 examples")
    person.click("do-Stop")
    person.sees("history", "GoFast → Stop, 2 examples")
    title = person.page.locator('[data-test="undo"]').get_attribute("title")
    assert title == "Take back: GoFast → Stop, 2 examples (U)"
    person.page.wait_for_selector('[data-test="undo"]:not([aria-disabled])')
    person.page.keyboard.press("u")
    undone = person.page.wait_for_selector('[data-test="history"] .undone')
    assert "GoFast → Stop" in undone.inner_text()
    person.click("redo")
    person.page.wait_for_selector('[data-test="history"] .undone', state="detached")
    person.sees("counts", "4 examples")


@needs_browser
def test_what_does_nothing_says_why_to_the_mouse_and_to_the_keyboard(swarm, person):
    begin(person, "Empty")
    person.page.keyboard.press("t")
    person.sees("message", "There is nothing to test yet")
    person.page.click('[data-test="save"]', force=True)
    person.sees("message", "There is nothing to save yet")
    undo = person.page.locator('[data-test="undo"]')
    assert "nothing to undo" in undo.get_attribute("title")
    undo.focus()  # it can be reached, unlike a disabled button
    person.page.keyboard.press("Enter")
    person.sees("message", "There is nothing to undo")
    person.page.keyboard.press("Escape")


@needs_browser
def test_features_and_behaviors_are_described_with_what_is_perceived_now(swarm, person):
    away_from_everybody(swarm, 6.0)
    person.click(f"agent-{ONE}")
    person.click("new")
    distance = "about-DistanceTo(ball)"
    person.sees(distance, "6 m")
    assert "distance to ball" in person.text(distance)
    assert "continuous, m" in person.text(distance)
    person.sees("about-BallIsKickable", "no")
    person.page.click("details summary")
    assert "turn to face the ball" in person.text("about-TurnToBall")
    person.page.keyboard.press("Escape")
    title = person.page.locator('[data-test="do-TurnToBall"]').get_attribute("title")
    assert "turn to face the ball" in title


@needs_browser
def test_a_key_stays_with_its_behavior_when_others_come_and_go(swarm, person):
    away_from_everybody(swarm, 5.0)

    def keys() -> dict[str, str]:
        shown = person.page.locator('[data-test="behaviors"] button').all_inner_texts()
        return dict(reversed(text.split()) for text in shown)  # type: ignore[misc,arg-type]

    person.click(f"agent-{TWO}")
    person.sees("do-GoFast")
    before = keys()
    person.click(f"agent-{ONE}")
    person.click("new")
    person.type("new-name", "Aardvark")  # before all others by its name
    person.tick("feature-DistanceTo(ball)")
    person.page.click("details summary")
    for state in ("Stop", "GoFast"):
        person.tick(f"state-{state}")
    person.click("begin")
    person.page.wait_for_selector('[data-test="do-GoSlow"]', state="detached")
    assert {name: keys()[name] for name in ("GoFast", "Stop")} == {
        name: before[name] for name in ("GoFast", "Stop")
    }
    person.click("do-GoFast")
    person.click("save")
    person.click("save-now")
    person.sees("do-Aardvark")
    after = keys()
    assert {name: after[name] for name in before} == before
    assert after["Aardvark"] not in before.values()


@needs_browser
def test_what_ends_a_performance_is_not_called_like_a_behavior(swarm, person):
    swarm.agents.perform(TWO, "GoSlow")
    person.click(f"agent-{TWO}")
    person.sees("mode", "Performing")
    banner = person.page.locator(".banner button").all_inner_texts()
    behaviors = person.page.locator('[data-test="behaviors"] button').all_inner_texts()
    names = {re.sub(r"^\S\n", "", text) for text in behaviors}
    assert not names & set(banner)
    person.click("idle")
    person.sees("mode", "Idle")
