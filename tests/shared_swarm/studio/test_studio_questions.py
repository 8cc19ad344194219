"""An agent asks on the page about its examples, and says there when it is unsure."""

from __future__ import annotations

import contextlib

import pytest
from browsing import ONE, away_from_everybody, begin, needs_browser, present_training

from hitab_client.errors import SwarmError
from hitab_core.operations import DiscardTraining, SetCaution


@pytest.fixture(autouse=True)
def nothing_is_trained(swarm):
    """Give up what another test has left."""
    with contextlib.suppress(SwarmError):  # nothing was left
        swarm.agents.do(ONE, DiscardTraining())


@needs_browser
def test_a_question_about_two_commands_is_answered_with_one_key_and_can_be_dismissed(
    swarm, person
):
    swarm.world.step(1)  # cycle 0 means unknown
    away_from_everybody(swarm, 5.0)
    begin(person, "Asks")
    # In GoFast, twice in the same situation, they say different things.
    shown = ("GoFast", "Stop", "GoFast", "GoSlow", "GoFast", "GoSlow")
    for examples, behavior in zip(range(2, 14, 2), shown, strict=True):
        person.click(f"do-{behavior}")
        person.sees("counts", f"{examples} examples")

    def contradicted() -> bool:
        return any(
            "which holds" in q.text for q in present_training(swarm, searched=True).questions
        )

    person.sees("questions", "which holds?")
    number = present_training(swarm, searched=True).questions[0].number
    proposed = person.page.wait_for_selector(f'[data-test="question-{number}"] button.strong')
    assert proposed.inner_text().split() == ["GoSlow", "A"]
    person.sees(f"question-{number}", "instead of GoSlow or Stop")
    person.sees(f"then-{number}-GoSlow", "Then: GoSlow")
    met = int(swarm.world.status.cycle)
    last = int(swarm.world.step(5).cycle)
    person.page.wait_for_function("cycle => studioField.shown === cycle", arg=last)
    person.click(f"show-{number}")
    person.page.wait_for_function("cycle => studioField.shown === cycle", arg=met)
    person.page.keyboard.press("Escape")
    person.does_not_see("past")
    person.click("save")
    person.sees("open-questions", "which holds?")
    person.page.keyboard.press("Escape")
    person.does_not_see("open-questions")
    person.page.keyboard.press("a")
    person.waits_until(lambda: not contradicted(), "it was not answered")
    assert all(
        e.next_state != "Stop" or e.kind == "default"
        for e in present_training(swarm).examples
        if e.state == "GoFast"
    )
    person.does_not_see(f"question-{number}")
    person.page.wait_for_selector('[data-test="undo"]:not([aria-disabled])')
    person.page.keyboard.press("u")
    person.sees(f"question-{number}", "which holds?")
    person.click(f"dismiss-{number}")
    person.does_not_see(f"question-{number}")
    person.sees("counts", "12 examples")


@needs_browser
def test_an_unsure_agent_says_why_and_does_what_was_chosen_for_that(swarm, person):
    begin(person, "Careful")
    for distance, behavior, examples in ((3.0, "GoFast", 2), (1.5, "Stop", 4), (3.0, "GoFast", 6)):
        away_from_everybody(swarm, distance)
        person.click(f"do-{behavior}")
        person.sees("counts", f"{examples} examples")
    person.click("caution-change")
    person.page.select_option('[data-test="caution-what"]', "halt")
    person.type("caution-distance", "2")
    person.click("caution-set")
    person.sees("caution-change", "halt")
    try:
        away_from_everybody(swarm, 8.0)
        person.click("toggle")
        person.sees("mode", "Testing")
        swarm.world.step(2)
        person.sees("unsure", "spreads of the examples from the nearest one")
    finally:
        swarm.agents.do(ONE, SetCaution("go_on"))
