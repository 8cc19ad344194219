"""Who hangs or has ended is said on the page, and what was asked of them is not lost."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import pytest
from browsing import ONE, Person, away_from_everybody, needs_browser, present_training, studio
from keepers import trained_keepers
from waiting import hanging, pid_of

from hitab_bringup.processes.bringing_up import temporary_swarm
from hitab_core.operations import BeginTraining
from hitab_studio.field.scene import SHOWN_MODES, SILENT_MODE

SECONDS = 60.0
SILENT_MODE = 1 + SHOWN_MODES.index(SILENT_MODE)


@pytest.fixture
def training(swarm, person) -> Person:
    """Somebody who trains keeper_1, with one command given."""
    away_from_everybody(swarm, 5.0)
    swarm.agents.do(ONE, BeginTraining("Lost", features=["DistanceTo(ball)"], discard=True))
    person.click(f"agent-{ONE}")
    person.click("do-GoFast")
    person.sees("counts", "2 examples")
    return person


def told_absent(person: Person) -> None:
    """Wait until the page says that the agent is suspended, wherever it shows the agent."""
    person.sees("absent", "is suspended (process ")
    person.sees(f"agent-{ONE}", "suspended")
    person.sees("absent-suspended", "1 suspended")
    person.sees("as-it-was", "last known state")
    person.waits_until(
        lambda: (
            person.page.evaluate(
                "name => { const f = window.studioField; return f.now.modes[f.index.get(name)]; }",
                ONE,
            )
            == SILENT_MODE
        ),
        "the field shows it as before",
    )
    off = person.page.locator('[data-test="do-GoSlow"]')
    assert "`kill -CONT" in off.get_attribute("title")
    assert off.get_attribute("aria-disabled") == "true"


@needs_browser
@pytest.mark.timeout(300)
def test_a_command_that_a_killed_agent_has_not_taken_is_sent_again(swarm, training):
    with hanging(swarm, ONE) as pid:
        training.click("do-Stop")
        training.sees("lost", "send again?")
        os.kill(pid, signal.SIGKILL)
        training.waits_until(lambda: pid_of(swarm, ONE) not in (0, pid), "restarted", SECONDS)
    training.page.wait_for_selector('[data-test="send-again"]:not([aria-disabled])')
    training.sees("mode", "Training")  # it has resumed from its journal
    training.sees("note", f"{ONE} resumed the interrupted training")
    training.does_not_see(f"fault-{ONE}")  # that is no fault
    training.click("send-again")
    training.does_not_see("lost")
    training.sees("counts", "4 examples")
    listed = present_training(swarm).examples
    assert [e.next_state for e in listed if e.kind != "default"] == ["GoFast", "Stop"]


@needs_browser
def test_a_world_that_hangs_is_said_and_its_controls_say_why_they_do_nothing(swarm, person):
    with hanging(swarm, "world"):
        person.sees("world-absent", "is suspended")
        person.sees("world-silent", "world suspended")
        assert person.page.locator(".overlay[data-stale]").count() == 1
        person.page.keyboard.press("n")
        person.sees("message", "The world is suspended")
        size = person.page.viewport_size
        for width in (1920, 820):
            person.page.set_viewport_size({**size, "width": width})
            hint = person.page.locator(".nudge").bounding_box()
            absent = person.sees("world-absent").bounding_box()
            assert hint["y"] + hint["height"] <= absent["y"], "nothing covers what is wrong"
        person.page.set_viewport_size(size)
    person.does_not_see("world-absent")
    cycle = swarm.world.status.cycle
    person.click("step")
    person.waits_until(
        lambda: swarm.link.spin(0.02) or swarm.world.state.cycle > cycle, "it is played again"
    )


@needs_browser
def test_a_page_waits_for_its_swarm_and_shows_it_only_while_it_is_up(chrome, home, tmp_path):
    """Its robots stood there as before, with a button that would train them."""
    description = trained_keepers(None, "", {}, count=1)

    @contextmanager
    def falls_up(someone: Person) -> Iterator[None]:
        with temporary_swarm(description, tmp_path / "falls") as running:
            running.folder.write(replace(running.record, swarm="falls"), register=True)
            someone.sees(f"agent-{ONE}")
            someone.sees_field()
            yield

    with studio(tmp_path / "log", "falls") as address:
        page = chrome.new_page(viewport={"width": 1280, "height": 720})
        someone = Person(page, address)
        page.wait_for_selector("text=is not up")
        with falls_up(someone):
            someone.click(f"agent-{ONE}")
            page.wait_for_selector("text=Nothing learned yet")
            someone.click("new")
            someone.type("new-name", "Chase")
        someone.sees("message", "The dialog was closed: falls is not there any more.")
        someone.does_not_see("new-name")
        page.wait_for_selector("text=is not up")
        someone.sees("unknown", "not known until it answers")
        assert page.locator("text=Nothing learned yet").count() == 0
        someone.click("tab-library")
        someone.sees("unknown", "not known until it answers")
        assert page.locator('[data-do="new"]:not([aria-disabled])').count() == 0
        assert page.locator(".overlay[data-stale]").count() == 1
        with falls_up(someone):
            page.wait_for_selector(".where b")
        assert someone.complaints == []
        page.close()
