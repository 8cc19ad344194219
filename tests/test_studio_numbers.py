"""Numbers are shown on the page: by dragging an arrow, in a form, and in the table of examples."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from pathlib import Path

import pytest
from browsing import ONE, away_from_everybody, begin, needs_browser, present_training
from keepers import trained_keepers

from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm
from hitab_client import SwarmError
from hitab_core.operations import DiscardTraining


@pytest.fixture(scope="module")
def swarm(home: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningSwarm]:
    """Three keepers that take numbers, in a paused world that will run in real time."""
    described = trained_keepers(None, "", {"taker_speed": 0.25}, domain="keepaway_continuous")
    with temporary_swarm(described, tmp_path_factory.mktemp("keepers")) as running:
        running.folder.write(running.record, register=True)
        running.world.control("pace", pace="realtime", factor=1.0)
        yield running


@pytest.fixture(autouse=True)
def nothing_is_trained(swarm):
    """Give up what another test has left."""
    swarm.world.control("pause")
    with contextlib.suppress(SwarmError):  # nothing was left
        swarm.agents.do(ONE, DiscardTraining())
    away_from_everybody(swarm, 6.0)


def shown(swarm):
    """Return the numbers of the examples that have some."""
    swarm.link.spin_until(lambda: swarm.agents.statuses[ONE].training.revision, 10.0)
    return [e.numbers for e in present_training(swarm).examples if e.numbers]


@needs_browser
def test_an_arrow_from_the_agent_shows_one_direction_while_the_world_stands_still(
    swarm, person, hitab
):
    begin(person, "Open", "DirectionTo(ball)")
    person.click("do-RunTowards")
    person.sees("showing", f"drag an arrow from {ONE}")
    person.drags(ONE, -6.0, 5.0)
    person.sees("recorded", "RunTowards(direction=")
    ((direction,),) = shown(swarm)
    assert direction == pytest.approx(90.0, abs=5.0)
    person.click("tab-examples")
    person.type("direction-1", "45")
    person.page.keyboard.press("Enter")
    person.waits_until(lambda: shown(swarm) == [(45.0,)], "it was corrected", 60.0)
    assert "RunTowards(direction=45)" in hitab("examples", ONE).stdout


@needs_browser
def test_an_arrow_shows_many_moments_while_the_world_runs_which_explain_what_it_does(
    swarm, person
):
    begin(person, "Open", "DirectionTo(ball)")
    person.click("do-RunTowards")
    person.sees("showing")
    swarm.world.control("resume")
    mouse, angle = person.page.mouse, 0.0
    x, y = person.on_screen(*person.place_of(ONE))
    mouse.move(x, y)
    mouse.down()

    def turns():
        nonlocal angle
        angle += 0.1
        mouse.move(x + 90 * math.cos(angle), y - 90 * math.sin(angle))
        return len(shown(swarm)) > 3

    person.waits_until(turns, "several moments were shown", 60.0)
    mouse.up()
    swarm.world.control("pause")
    person.page.keyboard.press("t")
    person.sees("mode", "Testing")
    swarm.world.control("resume")
    person.click("tab-learned")
    person.sees("numbers", "as in examples")


@needs_browser
def test_a_form_shows_several_numbers_and_refuses_those_beyond_their_bounds(swarm, person):
    begin(person, "Shoot", "DirectionTo(ball)")
    person.click("do-Kick")
    person.type("number-power", "80")
    person.type("number-direction", "30")
    person.click("show")
    person.sees("recorded", "Kick(power=80, direction=30)")
    assert shown(swarm) == [(80.0, 30.0)]
    person.page.keyboard.press("Escape")
    person.does_not_see("showing")
