"""Before and while people train, the page tells them what they need to know."""

from __future__ import annotations

import contextlib
from typing import Any

import pytest
from browsing import (
    ONE,
    TWO,
    Person,
    away_from_everybody,
    begin,
    needs_browser,
    present_training,
    visitor,
)

from hitab_client.errors import SwarmError
from hitab_core.operations import BeginTraining, DiscardTraining


@pytest.fixture(autouse=True)
def nothing_is_trained(swarm):
    """Give up what another test has left."""
    with contextlib.suppress(SwarmError):  # nothing was left
        swarm.agents.do(ONE, DiscardTraining())


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
        lambda: swarm.link.spin(0.02) or not swarm.agents.statuses[ONE].training.examples,
        "given up",
    )


@needs_browser
def test_the_history_shows_what_undo_undoes_and_redo_redoes(swarm, person):
    away_from_everybody(swarm, 5.0)
    begin(person, "Past")
    person.click("do-GoFast")
    person.sees("history", "Start → GoFast, 2 examples")
    person.click("do-Stop")
    person.sees("history", "GoFast → Stop, 2 examples")
    person.sees("counts", "4 examples")
    person.sees("counted", "3 examples count, 1 is overruled")
    title = person.page.locator('[data-test="undo"]').get_attribute("title")
    assert title == "Undo: GoFast → Stop, 2 examples; overruled example 2 (U)"
    person.page.wait_for_selector('[data-test="undo"]:not([aria-disabled])')
    person.page.keyboard.press("u")
    undone = person.page.wait_for_selector('[data-test="history"] .undone')
    assert "GoFast → Stop" in undone.inner_text()
    person.sees("cost", "2 commands, 1 undo, 2 examples deleted or undone")
    person.page.wait_for_selector('[data-test="redo"]:not([aria-disabled])')
    person.page.keyboard.press("y")
    person.page.wait_for_selector('[data-test="history"] .undone', state="detached")
    person.sees("counts", "4 examples")


@needs_browser
def test_the_world_is_not_paused_by_itself_while_somebody_else_trains(swarm, person, chrome, url):
    swarm.world.shown(swarm.world.control("resume"))
    with visitor(chrome, url) as other:
        other.click(f"agent-{TWO}")
        other.click("do-Stop")
        person.sees(f"agent-{TWO}", "Stop")
        person.click(f"agent-{ONE}")
        person.click("new")
        person.sees("new-pause")
        assert not person.page.is_checked('[data-test="new-pause"]')
        assert ", also for " in person.page.inner_text('[data-key="pause"]')
        person.page.keyboard.press("Escape")


@needs_browser
def test_long_names_of_states_do_not_make_the_panel_scroll_sideways(swarm, person):
    away_from_everybody(swarm, 5.0)
    begin(person, "Around")
    for target in ("bottom_left_corner", "bottom_right_corner"):
        person.click("do-TurnTo(X)")
        person.page.get_by_role("button", name=target).click()
        person.sees("recorded", target)
    person.page.set_viewport_size({"width": 1280, "height": 800})
    wide = "e => e.scrollWidth > e.clientWidth"
    assert not person.page.locator(".pane").evaluate(wide)


# -- for when a command counts ----------------------------------------------------------------

PRESS_LATER = """
([key, cycles]) => new Promise((done) => {
  const field = window.studioField, from = field.shown;
  function look() {
    if (field.shown < from + cycles) return requestAnimationFrame(look);
    const shown = field.shown;
    document.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
    done(shown);
  }
  look();
})
"""


# Loses the next message to the server with this text in it, as a connection does that has broken.
LOSE = """
text => {
  const { socket } = window, { emit } = socket;
  socket.emit = function (...sent) {
    if (!JSON.stringify(sent).includes(text)) return emit.apply(this, sent);
    socket.emit = emit;
    window.lost = true;
    return socket;
  };
}
"""


@pytest.fixture
def late(swarm: Any, person: Person) -> tuple[Person, int]:
    """Somebody who has stopped a running keeper late, and the cycle that was shown then."""
    away_from_everybody(swarm, 8.0)
    # The episode shall not end, however late an agent of a busy machine takes the command.
    far = {"ball": (-9.0, 9.0), "taker_1": (9.0, -9.0), "taker_2": (8.0, -9.0)}
    swarm.world.shown(swarm.world.place({name: {"x": x, "y": y} for name, (x, y) in far.items()}))
    # A feature could change meanwhile, which would be a reason to take the person for late.
    swarm.agents.do(ONE, BeginTraining("Late"))
    person.click(f"agent-{ONE}")
    person.sees("mode", "Training")
    person.click("do-GoFast")
    person.sees("counts", "2 examples")
    key = person.page.locator('[data-test="do-Stop"] kbd').inner_text().lower()
    swarm.world.control("pace", pace="realtime", factor=0.5)
    swarm.world.control("resume")
    try:
        shown = person.page.evaluate(PRESS_LATER, [key, 10])
        person.sees("counts", "4 examples")
    finally:
        swarm.world.control("pause")
        swarm.world.control("pace", pace="realtime", factor=1.0)
    person.sees("pause", "Resume")
    speed = '[data-change="pace"] option[value="1"][selected]'
    person.page.wait_for_selector(speed, state="attached")
    return person, shown


def stopped(swarm: Any) -> Any:
    """Return the example of the command to stop."""
    return next(e for e in present_training(swarm).examples if e.next_state == "Stop")


@needs_browser
def test_a_command_counts_for_what_its_person_saw_before(swarm, late):
    person, shown = late
    go, stop = present_training(swarm).examples[::2]
    assert go.ago == 0.0, "the world was paused: nothing had changed meanwhile"
    assert stop.cycle == shown, "nothing shows yet that the person is later than that"
    assert stop.state == "GoFast"
    person.sees("recorded", "Stop")
    if stop.ago > 0.0:
        person.sees("ago", f"{stop.ago:.2f} s ago")
    else:  # the keeper had met nothing newer when the command came
        person.does_not_see("ago")


@needs_browser
def test_a_command_that_came_late_is_put_right_with_one_key_or_in_its_row(swarm, late):
    person, _ = late
    before = stopped(swarm)
    for cycles in (1, 2):  # 0.2 s each, at half the pace while an agent is taught
        person.page.keyboard.press("b")
        person.waits_until(
            lambda n=cycles: before.cycle - stopped(swarm).cycle == n, "it was not due earlier"
        )
    assert stopped(swarm).ago == pytest.approx(before.ago + 0.2, abs=0.01)
    person.page.wait_for_selector('[data-test="undo"]:not([aria-disabled])')
    person.page.keyboard.press("u")
    person.waits_until(lambda: before.cycle - stopped(swarm).cycle == 1, "undo takes one back")
    person.click("tab-examples")
    cell = f"ago-{before.number}"
    person.type(cell, "1")
    person.page.keyboard.press("Enter")
    person.waits_until(lambda: stopped(swarm).ago == pytest.approx(1.0, abs=0.15), "in its row")
    field, shown = person.page.locator(f'[data-test="{cell}"]'), f"{stopped(swarm).ago:.2f}"
    person.waits_until(lambda: field.input_value() == shown, "the row shows it")
    person.type(cell, "9")
    person.page.keyboard.press("Enter")
    person.sees("message", "is too long ago")
    assert field.input_value() == shown, "what the agent refuses is not shown as if it were so"


@needs_browser
def test_what_a_broken_connection_has_lost_is_asked_again_in_order(swarm, person):
    begin(person, "Lossy")
    person.click("do-GoFast")
    person.sees("counts", "2 examples")
    person.page.evaluate(LOSE, "Stop")
    person.click("do-Stop")
    person.waits_until(lambda: person.page.evaluate("window.lost"), "it was sent")
    person.click("do-GoSlow")
    person.sees("counts", "6 examples")
    listed = present_training(swarm).examples
    of_commands = {e.command: e.next_state for e in reversed(listed)}
    assert list(of_commands.values())[::-1] == ["GoFast", "Stop", "GoSlow"]


@needs_browser
def test_what_is_sent_again_since_its_confirmation_was_lost_is_done_once(swarm, person):
    begin(person, "Deaf")
    confirmed = "window.confirmed = (window.confirmed || 0) + 1"
    deaf = f"window.hears = window.studioHeard; window.studioHeard = () => {{ {confirmed}; }}"
    person.page.evaluate(deaf)
    person.click("do-GoFast")
    person.waits_until(lambda: person.page.evaluate("window.confirmed > 2"), "it was sent again")
    person.page.evaluate("window.studioHeard = window.hears")
    person.click("do-Stop")
    person.sees("counts", "4 examples")
    of_commands = {e.command: e.next_state for e in reversed(present_training(swarm).examples)}
    assert list(of_commands.values())[::-1] == ["GoFast", "Stop"]


@needs_browser
def test_who_is_faster_than_the_page_may_undo_the_first_command(swarm, person):
    begin(person, "Fast")
    key = person.page.locator('[data-test="do-GoFast"] kbd').inner_text().lower()
    person.page.mouse.move(*person.on_screen(9.0, 9.0))
    person.page.mouse.down()  # the page stays as it is until the finger is up
    for pressed in (key, "u"):
        person.page.keyboard.press(pressed)
    person.waits_until(lambda: present_training(swarm).undone, "it is undone")
    person.page.mouse.up()
    assert not present_training(swarm).examples


# -- second thoughts --------------------------------------------------------------------------


@needs_browser
def test_features_are_exchanged_after_a_look_at_what_would_be_learned(swarm, person):
    begin(person, "Exchange")
    for distance, behavior, examples in ((6.0, "GoFast", 2), (0.8, "Stop", 4)):
        away_from_everybody(swarm, distance)
        person.click(f"do-{behavior}")
        person.sees("counts", f"{examples} examples")
    person.click("features-change")
    assert person.page.is_checked('[data-test="feature-DistanceTo(ball)"]')
    person.tick("feature-BallIsKickable")
    person.page.uncheck('[data-test="feature-DistanceTo(ball)"]')
    person.sees("features-effect", "+ GoFast: if BallIsKickable")
    labels = present_training(swarm).feature_labels
    assert labels == ("DistanceTo(ball)",), "nothing was done yet"
    person.click("features-accept")
    person.sees("recorded", "BallIsKickable")
    assert present_training(swarm).feature_labels == ("BallIsKickable",)
    person.page.wait_for_selector('[data-test="undo"]:not([aria-disabled])')
    person.page.keyboard.press("u")
    person.sees("recorded", "DistanceTo(ball)")


# -- the library ------------------------------------------------------------------------------


@needs_browser
def test_a_saved_behavior_is_renamed_and_deleted_on_the_page(swarm, person):
    def trained() -> list[str]:
        return [b.name for b in swarm.agents.vocabulary(ONE).behaviors if b.trained]

    away_from_everybody(swarm, 5.0)
    begin(person, "Near")
    person.click("do-GoFast")
    person.sees("counts", "2 examples")
    person.click("save")
    person.click("save-now")
    person.click("rename-behavior")
    person.type("behavior-name", "GoFast")
    person.click("rename-now")
    person.sees("refused", "that name is taken")
    person.type("behavior-name", "Close")
    person.click("rename-now")
    person.sees("shelf-Close")
    assert trained() == ["Close"]
    person.click("delete-behavior")
    person.click("delete-now")
    person.does_not_see("shelf-Close")
    person.sees("message", "its versions are kept")
    assert trained() == []
