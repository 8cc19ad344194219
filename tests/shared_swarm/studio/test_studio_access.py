"""Everybody can use the page: with keys alone, a screen reader, or eyes that need contrast."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from browsing import ONE, Person, away_from_everybody, needs_browser, visitor

from hitab_core import HitabError
from hitab_core.operations import BeginTraining, Command, DiscardTraining, Perform

MOST_TABS = 200


SEEN_FEATURES = ("DistanceTo(ball)", "DirectionTo(ball)")
SHOWN = ("GoFast", "Stop", "GoFast", "GoSlow")

ONLY_VIOLATIONS = {"resultTypes": ["violations"]}
ONLY_CONTRAST = ONLY_VIOLATIONS | {"runOnly": {"type": "rule", "values": ["color-contrast"]}}


def free(swarm: Any) -> None:
    """Have the keeper train nothing."""
    with suppress(HitabError):
        swarm.agents.do(ONE, DiscardTraining())
    swarm.agents.do(ONE, Perform())


def close_dialog(person: Person) -> None:
    person.page.keyboard.press("Escape")
    person.page.wait_for_selector("[data-modal]", state="detached")


def violations(person: Person, view: str) -> list[str]:
    """Return what axe-core finds wrong with the page as it is.

    All of its rules look at the light page; only what colors decide is looked at in the dark, too.
    """
    page, found = person.page, []
    if not page.evaluate("!!window.axe"):
        page.evaluate(Axe().axe_script)
    for theme, options in (("dark", ONLY_CONTRAST), ("light", ONLY_VIOLATIONS)):
        page.evaluate(
            "theme => document.documentElement.dataset.theme === theme || window.studioTheme()",
            theme,
        )
        answer = page.evaluate("options => axe.run(document, options)", options)
        found += [
            f"{view}, {theme}: {rule['id']} ({rule['help']}): {node['html'][:150]}"
            for rule in answer["violations"]
            for node in rule["nodes"]
        ]
    return found


@pytest.fixture
def looking(swarm: Any, chrome: Any, url: str) -> Iterator[Person]:
    """Somebody who looks at a keeper that trains nothing yet; nothing fades or moves."""
    free(swarm)
    away_from_everybody(swarm, 6.0)
    view = {"width": 1280, "height": 720}
    with visitor(chrome, url, viewport=view, reduced_motion="reduce") as someone:
        someone.click(f"agent-{ONE}")
        someone.sees("new")
        yield someone


@pytest.fixture
def teaching(swarm: Any, looking: Person) -> Person:
    """Somebody who has shown the keeper something, about which it asks a question."""
    swarm.agents.do(ONE, BeginTraining("Seen", features=list(SEEN_FEATURES), discard=True))
    for behavior in SHOWN:
        swarm.agents.do(ONE, Command(behavior))
    looking.sees("mode", "Training")
    looking.sees("counts", f"{2 * len(SHOWN)} examples")
    looking.sees("questions")
    return looking


@needs_browser
def test_axe_finds_nothing_wrong_before_a_training(swarm, looking):
    person = looking
    found = violations(person, "an agent")
    person.click("new")
    person.sees("begin")
    person.page.click('[data-test="parameter-details"] summary')
    found += violations(person, "what to train")
    close_dialog(person)
    person.page.keyboard.press("?")
    person.page.wait_for_selector(".keys")
    person.page.wait_for_function("document.activeElement.closest('.dialog')")
    top = person.page.evaluate("document.querySelector('.dialog').scrollTop")
    assert top == 0, "it is longer than the window, and its only button is at its end"
    found += violations(person, "keys and words")
    close_dialog(person)
    person.page.set_viewport_size({"width": 820, "height": 1180})
    found += violations(person, "on a tablet")
    person.page.reload()
    person.sees_field()
    found += violations(person, "at first")
    assert found == []


@pytest.mark.long
@needs_browser
def test_axe_finds_nothing_wrong_from_a_training_to_its_library(swarm, teaching, home):
    person, found = teaching, list[str]()

    def look(view: str, *shown: str) -> None:
        for name in shown:
            person.sees(name)
        found.extend(violations(person, view))

    look("training")
    person.click("stop-robots")
    person.sees("stopped")
    person.click("release")
    look("stopped robots", "release-dialog")
    person.click("release-now")
    person.does_not_see("stopped")
    for name, dialog in (
        ("generations-teach", "generations-dialog"),
        ("snapshots", "snapshot-name"),
    ):
        person.click(name)
        look(name, dialog)
        close_dialog(person)
    for name, button in (
        ("features", "features-change"),
        ("caution", "caution-change"),
        ("name", "who"),
    ):
        person.click(button)
        look(name, f"{name}-dialog")
        close_dialog(person)
    person.click("tab-examples")
    person.click("example-1")
    person.sees("marked")
    person.page.click('[data-test="columns"] summary')
    look("examples")
    person.click("tab-learned")
    look("learned", "node-GoFast")
    person.click("toggle")
    person.sees("mode", "Testing")
    look("testing")
    person.click("save")
    look("what is saved", "preview")
    person.click("save-now")
    look("library", "distribute")
    person.click("distribute")
    look("to whom it is given", "distribute-now")
    close_dialog(person)

    person.click("tab-swarm")
    look("swarm")
    person.click("tab-record")
    person.click("record")
    person.waits_until(lambda: list((home / "recordings").glob("*.mcap")), "being recorded")
    swarm.world.step(3)
    person.page.click('.pane [data-test="record"]')
    look("recordings", "replay-file")
    person.click("replay-file")
    look("a replay", "replay-band")
    person.click("label-dialog")
    look("what is labeled", "label")
    close_dialog(person)
    person.page.keyboard.press("Escape")
    person.does_not_see("replay-band")
    for path in (home / "recordings").glob("*.mcap"):
        path.unlink()
    assert found == []


# -- the keyboard -----------------------------------------------------------------------------


def reach(person: Person, name: str) -> None:
    """Go to something with Tab alone; on the way, the focus is always seen."""
    for _ in range(MOST_TABS):
        person.page.keyboard.press("Tab")
        there, seen = person.page.evaluate(
            "() => { const e = document.activeElement, s = getComputedStyle(e);"
            " const label = e.type === 'checkbox' && e.nextElementSibling;"
            " const l = label ? getComputedStyle(label) : s;"
            " return [e.dataset?.test || '', e === document.body || "
            " (s.outlineStyle !== 'none' && parseFloat(s.outlineWidth) > 0) ||"
            " (l.outlineStyle !== 'none' && parseFloat(l.outlineWidth) > 0)]; }"
        )
        assert seen, f"the focus is not seen at {there}"
        if there == name:
            return
    raise AssertionError(f"{name} cannot be reached with Tab")


@needs_browser
def test_a_person_trains_with_the_keyboard_alone(swarm, person):
    free(swarm)
    away_from_everybody(swarm, 6.0)
    keys = person.page.keyboard
    reach(person, f"agent-{ONE}")
    keys.press("Enter")
    person.sees("new")
    reach(person, "new")
    keys.press("Space")  # presses the button; the world stays paused
    person.sees("new-name")
    keys.type("Typed")
    reach(person, "feature-DistanceTo(ball)")
    keys.press("Space")
    reach(person, "begin")
    keys.press("Enter")
    person.sees("mode", "Training")
    assert swarm.world.wait().mode == "paused"
    reach(person, "do-GoFast")
    keys.press("Enter")
    person.sees("counts", "2 examples")
    reach(person, "do-Stop")
    keys.press("Space")
    person.sees("counts", "4 examples")
    reach(person, "tab-examples")
    keys.press("Enter")
    person.sees("example-1")
    reach(person, "delete-3")
    keys.press("Enter")
    person.does_not_see("example-3")
    reach(person, "tab-learned")
    keys.press("Enter")
    person.sees("node-Stop")
    reach(person, "node-Stop")
    keys.press("Enter")
    person.waits_until(
        lambda: person.page.get_attribute('[data-test="node-Stop"]', "aria-pressed") == "true",
        "its tree is shown",
    )
    # A dialog keeps the keyboard, and gives it back.
    reach(person, "save")
    keys.press("Enter")
    person.sees("preview")
    for _ in range(12):
        keys.press("Tab")
        assert person.page.evaluate(
            "() => { const e = document.activeElement; return e === document.body"
            " || !!e.closest('[data-modal], #panel-messages, #panel-emergency'); }"
        )
    keys.press("Escape")
    person.does_not_see("save-now")
    person.waits_until(
        lambda: person.page.evaluate("document.activeElement.dataset.test") == "save", "back"
    )


@needs_browser
def test_whatever_can_be_clicked_can_be_reached_with_the_keyboard(swarm, person):
    swarm.agents.do(ONE, BeginTraining("Reached", features=["DistanceTo(ball)"], discard=True))
    person.click(f"agent-{ONE}")
    person.click("do-GoFast")
    person.sees("counts", "2 examples")
    for tab in ("teach", "learned", "examples", "library", "swarm", "record"):
        person.click(f"tab-{tab}")
        person.waits_until(
            lambda t=tab: (
                person.page.get_attribute(f'[data-test="tab-{t}"]', "aria-selected") == "true"
            ),
            "shown",
        )
        unreached = person.page.evaluate(
            "() => [...document.querySelectorAll('#studio [data-do]')].filter(e =>"
            " e.tabIndex < 0 && !e.disabled && ![...e.querySelectorAll('[data-do]')].some(b =>"
            " b.tabIndex >= 0 && b.dataset.do === e.dataset.do)).map(e => e.outerHTML)"
        )
        assert unreached == [], tab
