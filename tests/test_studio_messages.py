"""What the studio says is seen, covers nothing, and can be closed."""

from __future__ import annotations

from browsing import ONE, needs_browser


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
