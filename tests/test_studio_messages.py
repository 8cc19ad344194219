"""What the studio says is seen, covers nothing, and can be closed."""

from __future__ import annotations

from typing import Any

from browsing import ONE, Person, needs_browser


def box_of(person: Person, selector: str) -> Any:
    return person.page.locator(selector).first.bounding_box()


def overlap(a: Any, b: Any) -> bool:
    return (
        a["x"] < b["x"] + b["width"]
        and b["x"] < a["x"] + a["width"]
        and a["y"] < b["y"] + b["height"]
        and b["y"] < a["y"] + a["height"]
    )


@needs_browser
def test_a_message_is_beside_the_field_counted_and_closed(swarm, person):
    before = box_of(person, "#stage")
    for _ in range(2):
        person.page.evaluate("window.studioTell('replay-play')")
    message = person.sees("message", "No recording is open")
    person.waits_until(
        lambda: message.query_selector(".times").inner_text().startswith("2"), "it is counted"
    )
    assert person.page.locator('[data-test="message"]').count() == 1
    assert not overlap(box_of(person, '[data-test="message"]'), box_of(person, "#stage"))
    assert box_of(person, "#stage") == before
    person.click("message-close")
    person.does_not_see("message")


@needs_browser
def test_messages_cover_no_button_of_a_dialog_and_can_be_closed_meanwhile(swarm, person):
    person.click(f"agent-{ONE}")
    for action in ("undo", "toggle", "replay-play"):
        person.page.evaluate("action => window.studioTell(action)", action)
    messages = person.page.locator('[data-test="message"]')
    person.waits_until(lambda: messages.count() == 3, "there are three messages")
    person.click("new")
    person.sees("begin")
    person.waits_until(
        lambda: overlap(box_of(person, ".dialog"), box_of(person, ".messages")),
        "the dialog is as large as its list of features makes it, or this shows nothing",
    )
    on_top = (
        "e => { const b = e.getBoundingClientRect();"
        + """
        return e.contains(document.elementFromPoint(b.right - 2, b.top + b.height / 2)); }"""
    )
    assert person.page.eval_on_selector('[data-test="begin"]', on_top)
    person.click("message-close")
    person.waits_until(lambda: messages.count() == 2, "it is closed")
    person.sees("begin")
    person.page.keyboard.press("Escape")
    person.does_not_see("begin")


@needs_browser
def test_a_name_that_cannot_be_is_answered_with_the_format_of_names(swarm, person):
    person.click(f"agent-{ONE}")
    person.click("new")
    person.type("new-name", "approach ball")
    person.click("begin")
    said = person.page.eval_on_selector('[data-test="new-name"]', "e => e.validationMessage")
    assert "letters, digits and _" in said
    person.type("new-name", "ApproachBall")
    assert person.page.eval_on_selector('[data-test="new-name"]', "e => e.checkValidity()")
    person.click("begin")
    person.sees("refused", "Choose at least one feature")
    person.does_not_see("message")
    # Also if it was pressed right after the last letter.
    person.page.eval_on_selector(
        '[data-test="new-name"]',
        """name => {
          for (const text of ["ApproachTheBall", "ApproachBall"]) {
            name.value = text;
            name.dispatchEvent(new Event("input", { bubbles: true }));
          }
          name.form.requestSubmit();
        }""",
    )
    person.page.wait_for_timeout(500)
    person.sees("refused", "Choose at least one feature")
    name, feature = '[data-test="new-name"]', '[data-test="feature-DistanceTo(ball)"]'
    person.tick("feature-DistanceTo(ball)")
    person.page.reload()  # as after the connection was lost
    person.click(f"agent-{ONE}")
    person.click("new")
    person.waits_until(lambda: person.page.input_value(name) == "ApproachBall", "it was filled in")
    person.waits_until(lambda: person.page.is_checked(feature), "it was ticked")
    person.page.keyboard.press("Escape")
    person.does_not_see("new-name")
    person.click("new")
    person.sees("feature-DistanceTo(ball)")
    assert person.page.input_value(name) == "", "the person has closed it"
    assert not person.page.is_checked(feature)


@needs_browser
def test_a_name_that_is_missing_is_asked_for_below_its_field(swarm, person):
    """The browser said "Please fill out this field." for some seconds."""
    person.click(f"agent-{ONE}")
    person.click("new")
    person.sees("feature-DistanceTo(ball)")
    missing, name = '[data-test="name-missing"]', '[data-test="new-name"]'
    assert not person.page.is_visible(missing), "nobody has tried yet"
    person.page.focus('[data-test="begin"]')
    person.click("begin")
    person.page.wait_for_selector(missing)
    assert person.text("name-missing").startswith("Give the behavior a name")
    assert box_of(person, missing)["y"] < box_of(person, name)["y"] + 60
    assert person.page.eval_on_selector(name, "e => e === document.activeElement")
    person.type("new-name", "Chase")
    assert not person.page.is_visible(missing)
    person.page.keyboard.press("Escape")
    person.does_not_see("new-name")


@needs_browser
def test_messages_name_agents_as_they_are_called(swarm, person):
    person.click(f"agent-{ONE}")
    person.click("do-Stop")
    assert person.sees("message").inner_text().startswith(f"{ONE} performs Stop")
