"""On the page, what an agent did in a recording is labeled, corrected and trained on."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from browsing import ONE, away_from_everybody, entity, needs_browser

from hitab_bringup.processes.bringing_up import RunningSwarm
from hitab_client.recording import Recorder
from hitab_client.recording.recordings import recordings_folder
from hitab_core.operations import Perform

SECONDS = 60.0


@pytest.fixture(scope="module")
def recorded(swarm: RunningSwarm) -> Iterator[str]:
    """Record how a hand-written automaton goes to the ball and stops there."""
    path = recordings_folder() / "shown.mcap"
    recorder = Recorder(swarm.link, path)

    def heard() -> bool:
        recorder.look()
        return f"/{ONE}" in recorder.perceiving and not recorder.awaited

    assert swarm.link.spin_until(heard, SECONDS)
    away_from_everybody(swarm, 7.0)
    swarm.agents.do(ONE, Perform("ServoBall"))
    before = recorder.bag.count
    swarm.world.step(40)  # of three keepers, each with a percept and an action
    assert swarm.link.spin_until(lambda: recorder.bag.count > before + 6 * 40, SECONDS)
    swarm.link.spin(0.5)
    recorder.close()
    swarm.agents.do(ONE, Perform())
    yield path.name
    path.unlink()


@needs_browser
def test_a_run_without_commands_is_labeled_corrected_trained_and_performed(
    swarm: RunningSwarm, person, recorded: str
) -> None:
    person.click("tab-record")
    person.click("replay-file")
    person.sees("replay-band", recorded)
    person.click(f"agent-{ONE}")
    person.click("label-dialog")
    for feature in ("DistanceTo(ball)", "BallIsKickable"):
        person.tick(f"feature-{feature}")
    person.click("label")
    person.sees("strip")
    first = person.sees("span-0")
    assert "GoFast" in first.get_attribute("title")
    person.click("span-1")
    was = person.sees("span-was")
    assert was.input_value() == "GoMedium"
    was.select_option("GoSlow")
    person.waits_until(
        lambda: "GoSlow, as you said" in (person.sees("span-1").get_attribute("title") or ""),
        "it was corrected",
        SECONDS,
    )
    person.type("label-name", "Copied")
    person.click("label-train")
    person.does_not_see("replay-band")
    person.sees("shelf-Copied")

    away_from_everybody(swarm, 7.0)
    person.click("perform")
    swarm.world.control("resume")
    person.waits_until(lambda: entity(swarm, ONE).x > -2.0, "it has gone to the ball", SECONDS)
    swarm.world.control("pause")
    assert swarm.agents.statuses[ONE].behavior == "Copied"


@needs_browser
def test_what_cannot_be_labeled_is_said(swarm: RunningSwarm, person, recorded: str) -> None:
    person.click("tab-record")
    person.click("replay-file")
    person.click(f"agent-{ONE}")
    person.click("label-dialog")
    person.click("label")
    person.sees("refused", "choose at least one feature")
    person.page.keyboard.press("Escape")
