"""A person looks back on the strip, commands for a moment that is past, and freezes the world."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from browsing import (
    ONE,
    Person,
    away_from_everybody,
    entity,
    needs_browser,
    present_training,
    visitor,
)

from hitab_core.operations import (
    BeginTraining,
    Command,
    DiscardTraining,
    Perform,
    SaveBehavior,
    SetBreakpoints,
    Undo,
)


@pytest.fixture
def watcher(swarm: Any, chrome: Any, url: str) -> Iterator[Person]:
    """Somebody who watches the first keeper, which is being trained in a paused world."""
    swarm.world.control("pause")
    away_from_everybody(swarm, 6.0)
    swarm.agents.do(ONE, BeginTraining("Back", features=["DistanceTo(ball)"], discard=True))
    with visitor(chrome, url) as someone:
        someone.click(f"agent-{ONE}")
        someone.sees("mode", "Training")
        yield someone
    swarm.agents.do(ONE, DiscardTraining())


def minute(person: Person, what: str) -> Any:
    """Return a part of the strip that the page shows."""
    return person.page.evaluate(f"studioField.minute{what}")


def run(swarm: Any, person: Person, cycles: int) -> int:
    """Run the world for some cycles, until the page shows the last one; return it."""
    last = int(swarm.world.step(cycles).cycle)
    person.page.wait_for_function("cycle => studioField.shown >= cycle", arg=last)
    return last


def breakpoints(swarm: Any, *wanted: str) -> bool:
    """Whether the first keeper comes to have these breakpoints."""
    return bool(
        swarm.link.spin_until(lambda: (*swarm.agents.statuses[ONE].breakpoints,) == wanted, 15.0)
    )


@needs_browser
def test_a_key_commands_for_the_moment_that_is_shown(swarm, watcher):
    swarm.agents.do(ONE, Command("GoFast"))
    start = run(swarm, watcher, 5)
    x = entity(swarm, ONE).x
    run(swarm, watcher, 20)
    assert entity(swarm, ONE).x > x + 1.0
    keys = watcher.page.keyboard
    for back in range(1, 21):
        keys.press(",")
        watcher.page.wait_for_function(
            "cycle => studioField.minute.past === cycle", arg=start + 20 - back
        )
    watcher.sees("past", "GoFast")
    assert watcher.place_of(ONE)[0] == pytest.approx(x, abs=1e-4)
    watcher.click("do-Stop")
    watcher.does_not_see("past")
    examples = present_training(swarm).examples
    (stop,) = [e for e in examples if e.next_state == "Stop" and not e.is_default]
    assert (stop.state, stop.cycle, stop.ago) == ("GoFast", start, 0.0)


@needs_browser
def test_a_person_who_pauses_the_running_world_commands_for_a_moment_before_that(swarm, watcher):
    swarm.agents.do(ONE, Command("GoFast"))
    start = swarm.world.state.cycle
    swarm.world.control("resume")
    assert swarm.link.spin_until(lambda: swarm.world.state.cycle >= start + 8, 20.0)
    watcher.page.keyboard.press("Space")
    assert swarm.link.spin_until(lambda: swarm.world.is_paused, 10.0)
    last = int(swarm.world.status.cycle)
    watcher.waits_until(lambda: minute(watcher, ".now") == last, "the strip is up to date")
    for _ in range(4):
        watcher.page.keyboard.press(",")
    watcher.page.wait_for_function("cycle => studioField.minute.past === cycle", arg=last - 4)
    watcher.sees("past", "commands it for this moment")
    watcher.click("do-Stop")
    watcher.does_not_see("past")
    examples = present_training(swarm).examples
    assert [e.cycle for e in examples if e.next_state == "Stop" and not e.is_default] == [last - 4]


@needs_browser
def test_the_strip_is_dragged_and_left_with_escape(swarm, watcher):
    swarm.agents.do(ONE, Command("GoFast"))
    last = run(swarm, watcher, 40)
    watcher.waits_until(lambda: minute(watcher, ".now") == last, "the strip is up to date")
    rows = {row["name"]: row for row in minute(watcher, ".rows")}
    assert [mark[1] for mark in rows[ONE]["marks"]].count("command") >= 1
    box = watcher.page.locator("#minute").bounding_box()
    left, right = minute(watcher, ".left"), minute(watcher, ".right")
    part = (last - 20 - left) / (right - left)
    place = box["x"] + 66 + part * (box["width"] - 66), box["y"] + 6
    watcher.page.mouse.move(*place)
    assert "GoFast" in watcher.page.get_attribute("#minute", "title")
    watcher.page.mouse.down()
    watcher.sees("past")
    watcher.page.mouse.up()
    assert watcher.page.evaluate("studioField.shown") == pytest.approx(last - 20, abs=2)
    watcher.page.keyboard.press("Shift+Period")
    watcher.page.wait_for_function("past => studioField.minute.past > past", arg=last - 15)
    watcher.page.keyboard.press("Escape")
    watcher.does_not_see("past")
    watcher.page.wait_for_function("cycle => studioField.shown === cycle", arg=last)


@needs_browser
def test_strip_and_field_stay_where_they_are_while_a_person_looks_back(swarm, watcher):
    def seen() -> Any:
        return watcher.page.evaluate("""() => {
            const { canvas: { height }, view: { scale, x, y } } = studioField;
            const strip = document.getElementById("minute");
            return [strip.clientHeight, strip.isSameNode(window.strip), height, scale, x, y];
        }""")

    swarm.agents.do(ONE, Command("GoFast"))
    last = run(swarm, watcher, 5)
    watcher.waits_until(lambda: minute(watcher, ".now") == last, "the strip is up to date")
    watcher.page.evaluate("window.strip = document.getElementById('minute')")
    before = seen()
    watcher.page.keyboard.press(",")
    watcher.sees("past", "GoFast")
    watcher.sees("continue-from")
    assert seen() == before
    watcher.drags(ONE, 3.0, 3.0)
    watcher.page.wait_for_selector("text=so nothing can be moved")
    assert entity(swarm, ONE).x < 0.0
    watcher.page.keyboard.press("Escape")
    watcher.does_not_see("continue-from")
    watcher.page.wait_for_function("cycle => studioField.shown === cycle", arg=last)
    assert seen() == before


@needs_browser
def test_the_first_key_freezes_the_world_and_the_second_one_chooses(swarm, watcher):
    watcher.page.check('[data-test="freezes"]')
    swarm.world.control("resume")
    key = watcher.page.get_attribute('[data-test="do-GoFast"]', "data-hotkey")
    watcher.page.keyboard.press(key)  # not meant for the box that was ticked
    watcher.sees("frozen")
    swarm.link.spin_until(lambda: swarm.world.is_paused, 10.0)
    assert swarm.world.is_paused
    frozen = entity(swarm, ONE), swarm.world.state.cycle
    assert not present_training(swarm).examples
    watcher.click("do-GoSlow")
    watcher.does_not_see("frozen")
    watcher.waits_until(lambda: present_training(swarm).examples, "the command was taken")
    (first, *_) = present_training(swarm).examples
    assert (first.next_state, first.cycle) == ("GoSlow", frozen[1])
    watcher.waits_until(lambda: not swarm.world.is_paused and swarm.link.spin(0.02) is None, "on")
    watcher.click("do-Stop")
    watcher.sees("frozen")
    watcher.page.keyboard.press("Escape")
    watcher.does_not_see("frozen")
    watcher.waits_until(lambda: not swarm.world.is_paused and swarm.link.spin(0.02) is None, "on")
    watcher.click("do-Stop")
    watcher.sees("frozen")
    swarm.world.control("resume")
    watcher.does_not_see("frozen")
    swarm.world.step(3)
    watcher.click("do-GoSlow")
    watcher.waits_until(lambda: len(present_training(swarm).examples) > 2, "the command was taken")
    swarm.link.spin(0.5)
    assert swarm.world.is_paused, "it was paused by somebody else, and rests"
    assert {e.next_state for e in present_training(swarm).examples} == {"GoSlow"}
    watcher.page.reload()
    watcher.click(f"agent-{ONE}")
    assert watcher.page.is_checked('[data-test="freezes"]')
    swarm.world.control("pause")


@needs_browser
def test_an_agent_that_is_not_trained_learns_nothing_for_the_past(swarm, watcher):
    swarm.agents.do(ONE, Perform("GoSlow"))
    run(swarm, watcher, 5)
    watcher.page.keyboard.press(",")
    watcher.sees("past")
    assert "commands it for this moment" not in watcher.text("past")
    watcher.click("do-Stop")
    watcher.page.wait_for_selector("text=is not being trained")


@needs_browser
def test_the_key_that_it_would_press_itself_is_marked(swarm, watcher):
    swarm.agents.do(ONE, Command("GoFast"))
    marked = "[data-test='do-GoFast'][class*='agrees-']"
    watcher.page.wait_for_selector(marked)
    watcher.waits_until(
        lambda: watcher.page.evaluate("studioField.previews")[ONE][0] == "GoFast", "in the field"
    )
    run(swarm, watcher, 3)
    watcher.page.keyboard.press(",")
    watcher.sees("past", "stay there")
    watcher.page.wait_for_selector(marked)


@needs_browser
def test_a_dot_of_the_drawing_sets_a_breakpoint_and_clears_it(swarm, watcher):
    for behavior in ("GoFast", "GoSlow"):
        swarm.agents.do(ONE, Command(behavior))
        run(swarm, watcher, 2)
    watcher.click("tab-learned")
    for place in ("GoSlow", "GoFast -> GoSlow", "unsure"):
        watcher.click(f"stop-{place}")
        watcher.sees(f"clear-{place}")
    assert breakpoints(swarm, "GoSlow", "GoFast -> GoSlow", "unsure")
    watcher.click("clear-unsure")
    watcher.does_not_see("clear-unsure")
    watcher.click("stop-GoSlow")
    watcher.does_not_see("clear-GoSlow")
    assert breakpoints(swarm, "GoFast -> GoSlow")


@needs_browser
def test_the_world_continues_from_the_moment_that_is_shown(swarm, watcher):
    swarm.agents.do(ONE, Command("GoFast"))
    start = run(swarm, watcher, 5)
    swarm.agents.do(ONE, Command("GoSlow"))
    run(swarm, watcher, 10)
    for _ in range(12):
        watcher.page.keyboard.press(",")
    watcher.page.wait_for_function("cycle => studioField.minute.past === cycle", arg=start - 2)
    watcher.click("continue-from")
    watcher.does_not_see("past")
    world = swarm.world
    assert swarm.link.spin_until(lambda: world.status.cycle == start - 2, 10.0)
    assert world.is_paused
    assert [*swarm.agents.read_features(ONE).active_path] == ["GoFast"]
    assert {e.next_state for e in present_training(swarm).examples} >= {"GoFast", "GoSlow"}
    assert world.step(1).cycle == start - 1


@needs_browser
def test_a_breakpoint_of_a_trained_behavior_holds_the_world_until_space_is_pressed(swarm, watcher):
    for behavior, distance in (("GoFast", 6.0), ("GoSlow", 3.0)):
        away_from_everybody(swarm, distance)
        swarm.agents.do(ONE, Command(behavior))
        swarm.world.step(1)
    away_from_everybody(swarm, 6.0)
    swarm.agents.do(ONE, SaveBehavior())
    swarm.agents.do(ONE, Perform("Back"))
    swarm.agents.do(ONE, SetBreakpoints(("GoSlow",)))
    swarm.world.control("resume")
    held = f"{ONE}: GoFast -> GoSlow"
    assert swarm.link.spin_until(lambda: swarm.world.status.held == held, 30.0)
    watcher.sees("held", "GoFast -> GoSlow")
    watcher.page.wait_for_selector('[data-test="pause"][title^="Resume"]')
    cycle = swarm.world.status.cycle
    watcher.page.keyboard.press("Space")
    assert swarm.link.spin_until(lambda: swarm.world.status.cycle > cycle + 2, 10.0)
    assert not swarm.world.status.held
    swarm.world.control("pause")
    swarm.agents.do(ONE, SetBreakpoints(()))
    swarm.agents.do(ONE, BeginTraining("Back", features=["DistanceTo(ball)"], discard=True))


@needs_browser
def test_a_command_three_seconds_late_by_going_back_learns_what_one_in_time_learns(swarm, watcher):
    def learned() -> object:
        training = present_training(swarm)
        examples = [(e.state, tuple(e.features), e.next_state) for e in training.examples]
        digests = {state: tree.digest() for state, tree in training.transitions.items()}
        return sorted(examples), digests

    swarm.agents.do(ONE, Command("GoFast"))
    start = run(swarm, watcher, 5)
    swarm.agents.do(ONE, Command("Stop"))
    in_time = learned()
    swarm.agents.do(ONE, Undo())
    swarm.world.go_back(to=start)
    last = run(swarm, watcher, 30)  # three seconds
    assert last == start + 30
    for _ in range(30):
        watcher.page.keyboard.press(",")
    watcher.page.wait_for_function("cycle => studioField.minute.past === cycle", arg=start)
    watcher.click("do-Stop")
    watcher.does_not_see("past")
    swarm.link.spin_until(lambda: learned() == in_time, 5.0)
    assert learned() == in_time
