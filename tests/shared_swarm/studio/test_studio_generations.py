"""Bootstrapping a team on the page: generations are made, listed, and gone back to."""

from __future__ import annotations

from browsing import THREE, TWO, away_from_everybody, begin, needs_browser, present_training


@needs_browser
def test_generations_of_a_team_are_made_listed_and_undone(swarm, person):
    away_from_everybody(swarm, 5.0)
    begin(person, "Together")
    person.click("do-GoFast")
    person.sees("counts", "2 examples")
    person.click("generations-teach")
    person.type("generation-episodes", "2")
    person.type("generation-note", "run")
    person.click("generation-next")
    person.sees("generation-1", "run")
    person.sees("making", "Done: keeper_1 is being trained further.")
    person.sees("generation-1", "current")
    assert "s" in person.text("generation-1")
    statuses = swarm.agents.statuses
    person.waits_until(
        lambda: (
            (swarm.link.spin(0.02) or [statuses[name].behavior for name in (TWO, THREE)])
            == ["Together", "Together"]
        ),
        "the team performs it",
    )
    person.page.keyboard.press("Escape")
    person.does_not_see("generations-dialog")
    person.sees("mode", "Training")
    person.page.wait_for_selector('[data-test="do-Stop"]:not([aria-disabled])')
    person.click("do-Stop")
    person.sees("counts", "4 examples")

    person.click("generations-teach")
    person.type("generation-episodes", "0")
    person.click("back-1")  # examples that are in no generation are not given up unasked
    person.sees("refused", "1 change to its training")
    person.click("generation-next")
    person.sees("generation-2", "current")
    person.sees("making", "Done: keeper_1 is being trained further.")
    person.page.wait_for_selector('[data-test="back-1"]:not([aria-disabled])')
    person.click("back-1")
    person.sees("generation-3", "version 1 again")
    person.sees("making", "Done: keeper_1 is being trained further.")
    person.page.keyboard.press("Escape")
    person.sees("counts", "2 examples")
    assert len(present_training(swarm).examples) == 2
