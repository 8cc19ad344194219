"""People train, arrange and watch in a real browser, over the public topics and services alone."""

from __future__ import annotations

import contextlib
import json
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from browsing import (
    ONE,
    TWO,
    Person,
    away_from_everybody,
    entity,
    needs_browser,
    present_training,
    studio,
    visitor,
)
from proxy import PATH, proxy

from hitab_client import SwarmError
from hitab_client.recording import RecordedMessages
from hitab_client.runs.users import user_name
from hitab_core.operations import BeginTraining, Command, Perform, SaveBehavior


@needs_browser
def test_a_person_arranges_a_scenario_by_dragging_and_takes_it_back(swarm, person):
    away_from_everybody(swarm, 6.0)
    person.waits_until(lambda: abs(person.place_of(ONE)[0] + 6.0) < 0.1, "shown")
    person.drags("ball", 3.0, 4.0)
    person.waits_until(lambda: abs(entity(swarm, "ball").x - 3.0) < 0.2, "the ball is there")
    assert entity(swarm, "ball").y == pytest.approx(4.0, abs=0.2)

    person.click("snapshots")
    person.type("snapshot-name", "corner")
    person.click("snapshot-save")
    person.sees("restore-corner")
    person.page.keyboard.press("Escape")

    person.drags("taker_1", -3.0, -3.0)
    person.waits_until(lambda: abs(entity(swarm, "taker_1").x + 3.0) < 0.2, "the taker is there")
    person.click("unplace")
    person.waits_until(lambda: abs(entity(swarm, "taker_1").x - 8.0) < 0.2, "taken back")

    person.drags("ball", -5.0, -5.0)
    person.waits_until(lambda: abs(entity(swarm, "ball").x + 5.0) < 0.2, "elsewhere")
    person.click("snapshots")
    person.click("restore-corner")
    person.waits_until(lambda: abs(entity(swarm, "ball").x - 3.0) < 0.2, "the snapshot is back")


@needs_browser
@pytest.mark.parametrize("cause", ["Escape", "pointercancel", "lostpointercapture", "blur"])
def test_a_drag_that_is_given_up_leaves_everything_where_it_was(swarm, person, cause):
    """Only letting go puts a thing somewhere: all else would place it where nobody meant it."""
    away_from_everybody(swarm, 6.0)
    person.waits_until(lambda: abs(person.place_of(ONE)[0] + 6.0) < 0.1, "shown")
    mouse, undoable = person.page.mouse, len(placements(person))
    mouse.move(*person.on_screen(*person.place_of("ball")))
    mouse.down()
    mouse.move(*person.on_screen(4.0, 4.0), steps=4)
    assert person.page.evaluate("window.studioField.drag.moved")
    if cause == "Escape":
        person.page.keyboard.press("Escape")
    elif cause == "blur":
        person.page.evaluate("window.dispatchEvent(new Event('blur'))")
    else:
        person.page.evaluate(
            "type => { const { canvas } = window.studioField;"
            " canvas.dispatchEvent(new PointerEvent(type, { pointerId: 1 })); }",
            cause,
        )
    mouse.move(*person.on_screen(5.0, 5.0), steps=2)
    mouse.up()
    assert person.place_of("ball") == pytest.approx((0.0, 0.0), abs=0.05)
    # The next thing that is placed is the next that the world hears of.
    person.drags("taker_1", -3.0, -3.0)
    person.waits_until(lambda: abs(entity(swarm, "taker_1").x + 3.0) < 0.2, "the taker is there")
    assert entity(swarm, "ball").x == pytest.approx(0.0, abs=0.05)
    assert len(placements(person)) == undoable + 1


def placements(person: Person) -> list[Any]:
    """Return what the page has sent to be placed so far."""
    return list(
        person.page.evaluate(
            "() => { if (!window.placed) { window.placed = []; const tell = window.studioTell;"
            " window.studioTell = (what, more) => { if (what === 'place') placed.push(more);"
            " tell(what, more); }; } return placed; }"
        )
    )


@needs_browser
def test_a_double_click_commands_once_and_steps_twice(swarm, person):
    """Else each hasty click records an example that nobody meant to give."""
    away_from_everybody(swarm, 5.0)
    swarm.agents.do(ONE, BeginTraining("Hasty", features=["DistanceTo(ball)"], discard=True))
    person.click(f"agent-{ONE}")
    person.sees("mode", "Training")
    person.page.dblclick('[data-test="do-GoFast"]')
    cycle = swarm.world.state.cycle
    person.page.dblclick('[data-do="step"]')
    person.waits_until(lambda: entity(swarm, ONE) and swarm.world.state.cycle == cycle + 2, "two")
    # What a page asks for is done in order: by now, all that the first double click has asked.
    assert [e.kind for e in present_training(swarm).examples] == [
        "demonstrated",
        "default",
    ]


@needs_browser
def test_the_target_of_a_behavior_is_given_by_clicking_it_in_the_field(swarm, person):
    away_from_everybody(swarm, 5.0)
    parameters = {"A": "closest_keeper"}
    chase = BeginTraining("Chase", ["DistanceTo(A)"], parameters=parameters, discard=True)
    swarm.agents.do(ONE, chase)
    swarm.agents.do(ONE, Command("GoFast"))
    swarm.agents.do(ONE, SaveBehavior())
    person.click(f"agent-{ONE}")
    person.click("do-Chase(A)")
    person.sees("asking", "Chase")
    person.page.mouse.click(*person.on_screen(*person.place_of("ball")))
    person.waits_until(
        lambda: swarm.link.spin(0.02) or swarm.agents.statuses[ONE].behavior == "Chase(ball)",
        "performs it with the ball",
    )
    person.click("do-Chase(A)")
    person.click("target-closest_taker")
    person.sees("banner", "Chase(closest_taker)")


@needs_browser
def test_contradicting_examples_are_pointed_out_and_deleting_one_shows_what_changes(swarm, person):
    away_from_everybody(swarm, 5.0)
    swarm.agents.do(ONE, BeginTraining("Torn", features=["DistanceTo(ball)"], discard=True))
    person.click(f"agent-{ONE}")
    for behavior in ("GoFast", "Stop", "GoFast", "GoSlow"):
        person.click(f"do-{behavior}")
    person.click("tab-examples")
    person.sees("contradictions", "2 examples disagree")
    person.click("delete-3")
    person.does_not_see("example-3")
    assert "always: GoSlow" in person.text("effect")
    assert 3 not in [e.number for e in present_training(swarm).examples]
    person.click("undo")
    person.sees("example-3")
    assert 3 in [e.number for e in present_training(swarm).examples]


@needs_browser
def test_what_an_idle_agent_perceives_is_shown(swarm, person):
    swarm.agents.do(TWO, Perform())
    person.click(f"agent-{TWO}")
    person.sees("perceives", "DistanceTo(ball)")


@needs_browser
def test_two_tabs_of_one_browser_are_one_person(swarm, chrome, url):
    swarm.agents.do(TWO, BeginTraining("Shared", features=["DistanceTo(ball)"], discard=True))
    with visitor(chrome, url) as one:
        two = Person(one.page.context.new_page(), url)
        for page, behavior in ((one, "GoFast"), (two, "Stop"), (one, "GoSlow")):
            page.click(f"agent-{TWO}")
            page.click(f"do-{behavior}")
            page.sees("recorded", behavior)
            page.sees(f"agent-{TWO}", "you")
            page.does_not_see("people")
        assert one.text("who") == two.text("who")
        assert two.complaints == []
        two.leave()
        one.leave()  # else the agent is held until its connection is given up


@needs_browser
def test_why_it_did_that_is_known_of_what_was_done_while_nobody_looked(swarm, person):
    person.click(f"agent-{ONE}")
    person.sees("banner", ONE)
    swarm.agents.do(TWO, BeginTraining("Unseen", features=["DistanceTo(ball)"], discard=True))
    for behavior in ("GoFast", "Stop"):  # as by the command line
        swarm.agents.do(TWO, Command(behavior))
    person.click(f"agent-{TWO}")
    person.click("tab-learned")
    person.page.wait_for_selector('.why:has-text("GoFast → Stop")')


@needs_browser
def test_one_demonstrator_commands_an_agent_and_another_can_take_it(swarm, person, chrome, url):
    swarm.agents.do(TWO, BeginTraining("Held", features=["DistanceTo(ball)"], discard=True))
    person.click(f"agent-{TWO}")
    person.click("do-GoFast")
    page = chrome.new_page(viewport={"width": 1280, "height": 720})
    other = Person(page, url)
    other.click("who")
    other.type("name", "Ben")
    other.click("name-set")
    other.sees("who", "Ben")
    other.click(f"agent-{TWO}")
    other.sees("banner", f"held by {user_name()}")
    assert page.is_disabled('[data-test="do-GoSlow"]')
    other.click("take")
    other.click("do-GoSlow")
    other.sees("recorded", "GoSlow")
    person.sees("message", f"has taken {TWO}")
    person.sees("banner", "held by Ben")
    person.waits_until(
        lambda: swarm.link.spin(0.02) or swarm.agents.statuses[TWO].training.demonstrator == "Ben",
        "told",
    )
    page.reload()
    other.sees("who", "Ben")
    assert other.complaints == []
    page.close()


@needs_browser
def test_who_leaves_or_loads_the_page_again_holds_no_agent_any_more(swarm, person):
    # The server would keep the page, and its agents, until it no longer waits for its connection.
    person.page.evaluate(
        """() => {
            dispatchEvent(new PageTransitionEvent("pagehide"));
            return new Promise((gone) => {
                const look = () => {
                    const url = `ws://${location.host}/field?page=${STUDIO_PAGE}`;
                    const socket = new WebSocket(url);
                    socket.onopen = () => setTimeout(() => socket.close(), 200);
                    socket.onclose = ({ code }) => (code === 4404 ? gone() : look());
                };
                look();
            });
        }"""
    )


@needs_browser
def test_a_run_is_recorded_and_replayed_on_the_same_page(swarm, person, home):
    person.click(f"agent-{ONE}")
    person.click("tab-record")
    person.click("record")
    recordings = home / "recordings"
    person.waits_until(lambda: recorded_place(recordings) is not None, "it is recorded")
    away_from_everybody(swarm, 3.0)
    swarm.world.step(5)
    away_from_everybody(swarm, 9.0)
    person.waits_until(lambda: abs(person.place_of(ONE)[0] + 9.0) < 0.3, "it is shown there")
    person.waits_until(lambda: abs((recorded_place(recordings) or 0.0) + 9.0) < 0.1, "it as well")
    person.page.click('.pane [data-test="record"]')
    person.click("replay-file")
    person.sees("replay")
    # It is not taken for the swarm: another frame, and nothing that would act.
    person.sees("replay-band", "Replay")
    for live in ("pause", "step", "new", "behaviors", "tab-teach"):
        person.does_not_see(live)
    person.page.evaluate(
        "() => { const line = document.querySelector('[data-test=timeline]');"
        " line.value = line.max; line.dispatchEvent(new Event('input', { bubbles: true })); }"
    )
    person.waits_until(lambda: abs(person.place_of(ONE)[0] + 9.0) < 0.3, "its last moment")
    person.page.keyboard.press("Escape")
    person.does_not_see("replay")
    person.sees("pause")
    recorded, (path,) = path_and_download(person, home)
    assert recorded == path.read_bytes()
    person.click(f"rename-{path.name}")
    person.type("recording-name", "the last one")
    person.click("rename-now")
    person.sees("download-the last one.mcap")
    assert (home / "recordings" / "the last one.mcap").read_bytes() == recorded

    found = {message.topic for message in RecordedMessages(recordings / "the last one.mcap")}
    assert {"/world/state", "/world/status", f"/{ONE}/status"} <= found
    person.click("delete-the last one.mcap")
    person.click("delete-now")
    person.does_not_see("download-the last one.mcap")
    assert list((home / "recordings").glob("*")) == []


def recorded_place(recordings: Path) -> float | None:
    """Return where the only recording has the first keeper at last, m; None if nowhere yet."""
    for path in recordings.glob("*.mcap"):
        with contextlib.suppress(SwarmError):
            for message in reversed(list(RecordedMessages(path))):
                if message.topic == "/world/state":
                    return float(next(e.x for e in message.decoded().entities if e.name == ONE))
    return None


def path_and_download(person: Person, home: Path) -> tuple[bytes, list[Path]]:
    """Return what the page gives for download, and the recordings that there are."""
    paths = list((home / "recordings").glob("*.mcap"))
    with person.page.expect_download() as download:
        person.click(f"download-{paths[0].name}")
    return Path(download.value.path()).read_bytes(), paths


def ask(url: str, **headers: str) -> int:
    try:
        with urllib.request.urlopen(
            urllib.request.Request(url, headers=headers), timeout=5
        ) as got:
            return int(got.status)
    except urllib.error.HTTPError as error:
        return int(error.code)


def test_requests_of_other_sites_are_refused(url):
    assert ask(url) == 200
    assert ask(url, Origin="http://evil.example") == 403
    assert ask(url, Host="evil.example") == 403
    assert (
        ask(url + "_nicegui_ws/socket.io/?EIO=4&transport=polling", Origin="http://x.example")
        == 403
    )


def test_another_address_needs_a_token(home, tmp_path, hitab):
    with studio(tmp_path / "log", "--host", "0.0.0.0", "--token", "a-good-token") as address:
        assert ask(address) == 401
        assert ask(address + "?token=wrong-token") == 401
        assert ask(address, Cookie="hitab_studio_token=a-good-token") == 200
        opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
        with opener.open(address + "?token=a-good-token", timeout=5) as welcome:
            assert welcome.status == 200
    refused = hitab("studio", "--token", "short", "--no-browser")
    assert refused.returncode == 1
    assert "at least 8" in json.dumps(refused.stderr)


@needs_browser
def test_behind_a_proxy_it_is_used_as_without_one_by_names_that_are_allowed(
    swarm, chrome, home, tmp_path, url
):
    allowed = ("--allow-host", "localhost", "--root-path", PATH)
    with (
        studio(tmp_path / "log", "--token", "a-good-token", *allowed) as address,
        proxy(urlsplit(address).port) as shown,
        visitor(chrome, f"{shown}?token=a-good-token") as person,
    ):
        assert person.page.url == shown
        person.click(f"agent-{ONE}")
        person.sees("perceives", "DistanceTo(ball)")
        person.drags("ball", 2.0, 2.0)
        person.waits_until(lambda: abs(entity(swarm, "ball").x - 2.0) < 0.2, "it is there")
    with proxy(urlsplit(url).port) as shown:
        page = chrome.new_page()
        page.goto(shown.removesuffix(PATH[1:] + "/"))
        why = "start the studio with --allow-host localhost"
        page.wait_for_function(f"document.body.textContent.includes('{why}')")
        page.close()
