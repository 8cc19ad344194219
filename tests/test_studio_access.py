"""Everybody can use the page: with keys alone, a screen reader, or eyes that need contrast."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from browsing import ONE, Person, away_from_everybody, entity, needs_browser, studio, visitor

from hitab_core import HitabError

MOST_TABS = 200


def free(swarm: Any) -> None:
    """Have the keeper train nothing."""
    with suppress(HitabError):
        swarm.agents.discard(ONE)
    swarm.agents.perform(ONE, "")


def close_dialog(person: Person) -> None:
    person.page.keyboard.press("Escape")
    person.page.wait_for_selector("[data-modal]", state="detached")


def violations(person: Person, view: str) -> list[str]:
    """Return what axe-core finds wrong with the page as it is."""
    person.page.wait_for_timeout(250)  # what fades in has its final color
    found = Axe().run(person.page).response["violations"]
    return [
        f"{view}: {rule['id']} ({rule['help']}): {node['html'][:150]}"
        for rule in found
        for node in rule["nodes"]
    ]


@pytest.fixture(params=["light", pytest.param("dark", marks=pytest.mark.long)])
def looking(request: Any, chrome: Any, url: str) -> Iterator[Person]:
    """Somebody whose browser is light or dark."""
    view = {"width": 1280, "height": 720}
    with visitor(chrome, url, viewport=view, color_scheme=request.param) as someone:
        yield someone


@needs_browser
def test_axe_finds_nothing_wrong_with_any_view(swarm, looking, home):
    person, found = looking, []

    def check(view: str) -> None:
        found.extend(violations(person, view))

    free(swarm)
    away_from_everybody(swarm, 6.0)
    check("at first")
    person.click(f"agent-{ONE}")
    person.sees("new")
    check("an agent")
    person.click("new")
    person.sees("begin")
    check("what to train")
    person.type("new-name", "Seen")
    person.tick("feature-DistanceTo(ball)")
    person.tick("feature-DirectionTo(ball)")
    person.click("begin")
    person.sees("mode", "Training")
    for behavior, examples in (("GoFast", 2), ("Stop", 4), ("GoFast", 6), ("GoSlow", 8)):
        person.click(f"do-{behavior}")
        person.sees("counts", f"{examples} examples")
    person.sees("questions")
    check("training")
    for name in ("features", "caution", "reaction"):
        person.click(f"{name}-change")
        person.sees(f"{name}-dialog")
        check(name)
        if name != "reaction":
            close_dialog(person)
    person.click("reaction-game")
    person.sees("disc")
    check("the game")
    person.click("reaction-cancel")
    person.click("tab-examples")
    person.click("example-1")
    person.sees("marked")
    person.page.click('[data-test="columns"] summary')
    check("examples")
    person.click("tab-learned")
    person.sees("node-GoFast")
    check("learned")
    person.click("toggle")
    person.sees("mode", "Testing")
    check("testing")
    person.click("save")
    person.sees("preview")
    check("what is saved")
    person.click("save-now")
    person.sees("distribute")
    check("library")
    person.click("distribute")
    person.sees("distribute-now")
    check("to whom it is given")
    close_dialog(person)
    person.click("snapshots")
    person.sees("snapshot-name")
    check("snapshots")
    close_dialog(person)
    person.page.keyboard.press("?")
    person.page.wait_for_selector(".keys")
    check("keys")
    close_dialog(person)
    person.page.evaluate("window.studioTell('replay-play')")
    person.sees("message", "No recording is open")
    person.click("tab-swarm")
    check("swarm and a message")
    person.click("tab-record")
    person.click("record")
    person.waits_until(lambda: list((home / "recordings").glob("*.mcap")), "being recorded")
    swarm.world.step(3)
    person.page.click('.pane [data-test="record"]')
    person.sees("replay-file")
    check("recordings")
    person.click("replay-file")
    person.sees("replay-band")
    check("a replay")
    person.page.keyboard.press("Escape")
    person.does_not_see("replay-band")
    person.page.set_viewport_size({"width": 820, "height": 1180})
    check("on a tablet")
    for path in (home / "recordings").glob("*.mcap"):
        path.unlink()
    assert found == []


@needs_browser
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_wrong_while_no_swarm_is_up(
    chrome: Any, home: Path, tmp_path: Path, scheme: str
):
    with studio(tmp_path / "log", "not_there") as address:
        page = chrome.new_page(
            viewport={"width": 1280, "height": 720}, color_scheme=scheme, reduced_motion="reduce"
        )
        someone = Person(page, address)
        page.wait_for_selector("text=is not up")
        assert violations(someone, "no swarm") == []
        page.close()


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
            " || !!e.closest('[data-modal], #panel-messages'); }"
        )
    keys.press("Escape")
    person.does_not_see("save-now")
    person.waits_until(
        lambda: person.page.evaluate("document.activeElement.dataset.test") == "save", "back"
    )


@needs_browser
def test_whatever_can_be_clicked_can_be_reached_with_the_keyboard(swarm, person):
    swarm.agents.begin(ONE, "Reached", features=["DistanceTo(ball)"], discard=True)
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


# -- motion -----------------------------------------------------------------------------------


@needs_browser
def test_nothing_blinks_for_who_wants_no_motion(swarm, chrome, url, home):
    context = chrome.new_context(reduced_motion="reduce")
    someone = Person(context.new_page(), url)
    someone.click("tab-record")
    someone.click("record")
    someone.page.wait_for_selector(".blink")
    moving = "document.getAnimations().map((one) => one.animationName ?? one.transitionProperty)"
    assert someone.page.evaluate(moving) == []
    someone.page.click('.pane [data-test="record"]')
    someone.sees("replay-file")
    for path in (home / "recordings").glob("*.mcap"):
        path.unlink()
    assert entity(swarm, ONE)
    context.close()
