"""Whoever does what the studio's page says to do in two minutes has trained a keeper that plays.

Each step quotes what it does from the page, and the steps together quote all of the guide.
"""

from __future__ import annotations

import math
import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from browsing import ONE, Person, entity, needs_browser

PAGE = Path(__file__).resolve().parents[1] / "docs/studio.md"
TITLE = "## Train something in two minutes"
NAME = "FetchBall"
KICKABLE_M = 1.085  # how near the ball is kicked
EPISODES = 6
MANY_EPISODES = 20  # with --long
A_LITTLE, FARTHER = 12.0, 40.0  # degrees beside the ball

Do = Callable[[Person, Any], None]
STEPS: list[tuple[str, Do]] = []


def step(quote: str) -> Callable[[Do], Do]:
    """Take a function as what a person does who reads this."""

    def register(does: Do) -> Do:
        STEPS.append((quote, does))
        return does

    return register


def guide() -> str:
    """Return the numbered list of the page, without its numbers and line breaks."""
    section = PAGE.read_text(encoding="utf-8").partition(TITLE)[2].partition("\n## ")[0]
    listed = re.findall(r"^\d+\. (.*(?:\n {3}.*)*)", section, re.MULTILINE)
    return " ".join(" ".join(listed).split())


def press(person: Person, key: str, name: str) -> None:
    """Press a key once what it stands for can be done: on a busy machine an agent may be late."""
    person.page.wait_for_selector(f'[data-test="{name}"]:not([aria-disabled])')
    person.page.keyboard.press(key)


def press_key_of(person: Person, behavior: str) -> None:
    button = person.page.locator(f'[data-test="do-{behavior}"]')
    press(person, button.locator("kbd").inner_text().lower(), f"do-{behavior}")
    person.page.wait_for_selector(f'[data-test="do-{behavior}"].active')


def bearing(person: Person) -> float:
    """Return where the ball is, seen from the keeper, as the page shows it, in degrees."""
    (x, y), (ball_x, ball_y) = person.place_of(ONE), person.place_of("ball")
    return math.degrees(math.atan2(ball_y - y, ball_x - x))


def turn(person: Person, swarm: Any, degrees: float) -> None:
    """Drag the knob at the keeper until it looks this far to the left of the ball."""
    heading = math.radians(bearing(person) + degrees)
    person.waits_until(
        lambda: person.page.evaluate("window.studioField.handles.length") == 1, "it has a knob"
    )
    knob = person.page.evaluate("window.studioField.handles[0]")
    box = person.page.locator("canvas#field").bounding_box()
    x, y = person.place_of(ONE)
    person.page.mouse.move(box["x"] + knob["x"], box["y"] + knob["y"])
    person.page.mouse.down()
    far = person.on_screen(x + 2 * math.cos(heading), y + 2 * math.sin(heading))
    person.page.mouse.move(*far, steps=4)
    person.page.mouse.up()

    def turned() -> bool:
        off = entity(swarm, ONE).heading - heading
        return abs(math.atan2(math.sin(off), math.cos(off))) < math.radians(4)

    person.waits_until(turned, "it was not turned")


def drag(person: Person, swarm: Any, name: str, x: float, y: float) -> None:
    person.drags(name, x, y)
    person.waits_until(lambda: abs(entity(swarm, name).x - x) < 0.2, f"{name} was not moved")
    person.waits_until(lambda: math.dist(person.place_of(name), (x, y)) < 0.2, "it is not shown")


@step("Click `keeper_1`, then **Train…**.")
def opens(person: Person, swarm: Any) -> None:
    person.click(f"agent-{ONE}")
    person.click("new")


@step(
    "Name the behavior `FetchBall`, tick the features `BallIsKickable` and `DirectionTo(ball)`, "
    "and click **Begin**."
)
def begins(person: Person, swarm: Any) -> None:
    assert swarm.world.status.mode == "running", "nobody has paused it yet"
    person.type("new-name", NAME)
    for feature in ("BallIsKickable", "DirectionTo(ball)"):
        person.tick(f"feature-{feature}")
    person.click("begin")


@step("The world pauses and the frame turns amber: you decide.")
def sees_the_frame(person: Person, swarm: Any) -> None:
    person.sees("mode", "Training")
    person.waits_until(
        lambda: swarm.link.spin(0.02) or swarm.world.status.mode == "paused", "it runs on"
    )
    person.page.wait_for_selector('.overlay[data-mode="training"]')


@step(
    "Drag the ball to the middle of the field, and the keeper far to the left of it. Drag whoever "
    "stands beside it out of the way."
)
def places(person: Person, swarm: Any) -> None:
    drag(person, swarm, "ball", 0.0, 0.0)
    drag(person, swarm, ONE, -7.0, 0.0)
    for i, name in enumerate(("keeper_2", "keeper_3", "taker_1", "taker_2")):
        there = entity(swarm, name)
        if math.dist((there.x, there.y), (-7.0, 0.0)) < 3.0:
            drag(person, swarm, name, 8.0, 6.0 - 3.0 * i)


@step(
    "A keeper runs where it looks, so its heading matters: drag the small knob at the keeper "
    "until it looks away from the ball."
)
def turns_away(person: Person, swarm: Any) -> None:
    turn(person, swarm, 150.0)


@step("Press the key on the button `TurnToBall`.")
def turn_to_ball(person: Person, swarm: Any) -> None:
    press_key_of(person, "TurnToBall")


@step(
    "*Just recorded* shows the example with what the keeper saw, and below it the default "
    "example: otherwise, go on turning."
)
def sees_the_examples(person: Person, swarm: Any) -> None:
    person.sees("counts", "2 examples")
    texts = person.page.locator('[data-test="recorded"]').all_inner_texts()
    assert ["default" in text for text in texts] == [False, True]
    assert all("DirectionTo(ball)" in text and "TurnToBall" in text for text in texts)


@step(
    "Turn the keeper until it looks almost at the ball, a little to the left of it, and press "
    "the key of `GoFast`. Turn it farther to the left and press the key of `TurnToBall`."
)
def shows_the_left(person: Person, swarm: Any) -> None:
    for degrees, behavior in ((A_LITTLE, "GoFast"), (FARTHER, "TurnToBall")):
        turn(person, swarm, degrees)
        press_key_of(person, behavior)


@step(
    "Do the same on the other side: a little to the right of the ball `GoFast`, farther to the "
    "right `TurnToBall`."
)
def shows_the_right(person: Person, swarm: Any) -> None:
    for degrees, behavior in ((-A_LITTLE, "GoFast"), (-FARTHER, "TurnToBall")):
        turn(person, swarm, degrees)
        press_key_of(person, behavior)


@step(
    "Drag the keeper to the ball, until *Perceives now* answers `BallIsKickable` with yes, and "
    "press the key of `Stop`."
)
def stops(person: Person, swarm: Any) -> None:
    drag(person, swarm, ONE, -0.7, 0.0)
    person.page.wait_for_selector('.reading:has-text("BallIsKickable") .bool.yes')
    press_key_of(person, "Stop")


@step(
    "Drag the ball far behind the keeper: `TurnToBall`. Turn the keeper to the ball: `GoFast`. "
    "Drag it to the ball: `Stop`."
)
def shows_all_once_more(person: Person, swarm: Any) -> None:
    drag(person, swarm, "ball", -8.0, 0.0)
    press_key_of(person, "TurnToBall")
    turn(person, swarm, 0.0)
    press_key_of(person, "GoFast")
    drag(person, swarm, ONE, -7.3, 0.0)
    person.page.wait_for_selector('.reading:has-text("BallIsKickable") .bool.yes')
    press_key_of(person, "Stop")
    person.sees("counts", "18 examples")


@step("Press `T`: now what the keeper has learned decides, and the frame turns teal.")
def hands_over(person: Person, swarm: Any) -> None:
    press(person, "t", "toggle")
    person.page.wait_for_selector('.overlay[data-mode="testing"]')


@step(
    "Press `R` for a new episode and Space to let the world run. The keeper turns to the ball, "
    "runs to it and stops."
)
def lets_it_run(person: Person, swarm: Any) -> None:
    before = swarm.world.status.episode
    press(person, "r", "pause")
    person.waits_until(
        lambda: swarm.link.spin(0.02) or swarm.world.status.episode > before, "no new episode"
    )
    person.waits_until(lambda: state_of(swarm) == "Start", "it does not begin at Start")
    swarm.world.control("pace", pace="realtime", factor=0.25)  # this machine may be busy
    press(person, " ", "pause")
    person.waits_until(lambda: stands_at_the_ball(swarm), "it has not come to the ball", 60.0)


@step(
    "When a taker has won the ball, the next episode begins, and the keeper does the same again."
)
def plays_on(person: Person, swarm: Any) -> None:
    swarm.world.control("pace", pace="realtime", factor=1.0)
    episode = swarm.world.status.episode

    person.waits_until(
        lambda: stands_at_the_ball(swarm) and swarm.world.status.episode > episode,
        "it does not do it again",
        60.0,
    )
    swarm.world.control("pause")


@step(
    "**Save…** shows what will be kept and what is trimmed, and lets you turn a target into a "
    "parameter."
)
def saves(person: Person, swarm: Any) -> None:
    person.click("save")
    person.sees("preview", NAME)
    assert "becomes" in person.page.inner_text(".dialog")
    person.click("save-now")


@step("**Distribute…** sends the behavior to the others and shows each acknowledgement.")
def distributes(person: Person, swarm: Any) -> None:
    person.click("distribute")
    person.click("distribute-now")
    for name in ("keeper_2", "keeper_3"):
        person.sees("acks", f"{name} has it")
    person.click("done")


def state_of(swarm: Any) -> str:
    """Return the active state of the keeper."""
    swarm.link.spin(0.02)
    return next(iter(swarm.agents.statuses[ONE].active_path), "")


def stands_at_the_ball(swarm: Any) -> bool:
    keeper, ball = entity(swarm, ONE), entity(swarm, "ball")
    near = math.dist((keeper.x, keeper.y), (ball.x, ball.y)) < KICKABLE_M
    return near and state_of(swarm) == "Stop"


def test_the_steps_below_are_those_of_the_page():
    """Else the page may tell people to do something else than what is tried here."""
    assert guide() == " ".join(quote for quote, _ in STEPS)


@needs_browser
def test_who_does_what_the_page_says_has_a_keeper_that_reaches_the_ball(swarm, person, request):
    episodes = MANY_EPISODES if request.config.getoption("long") else EPISODES
    swarm.world.control("resume")
    person.waits_until(
        lambda: swarm.link.spin(0.02) or swarm.world.status.mode == "running", "it does not run"
    )
    for _, does in STEPS:
        does(person, swarm)

    swarm.world.control("pause")
    swarm.world.control("pace", pace="lockstep")
    swarm.agents.perform(ONE, NAME)
    random_ = random.Random(3)
    failed = []
    for number in range(episodes):
        things = {
            name: {"x": random_.uniform(-far, far), "y": random_.uniform(-far, far)}
            for name, far in ((ONE, 8.0), ("ball", 4.0))  # the takers must not be there first
        }
        things[ONE]["heading"] = random_.uniform(-math.pi, math.pi)
        corners = {
            "keeper_2": (9, 9),
            "keeper_3": (9, -9),
            "taker_1": (-9, 9),
            "taker_2": (-9, -9),
        }
        things |= {name: {"x": x, "y": y} for name, (x, y) in corners.items()}
        still = {name: {"vx": 0.0, "vy": 0.0, **place} for name, place in things.items()}
        swarm.world.shown(swarm.world.place(still, new_episode=True))
        if not reaches(swarm):
            failed.append((number, things[ONE], things["ball"]))
    swarm.world.control("pace", pace="realtime", factor=1.0)
    assert failed == [], f"{len(failed)} of {episodes}"


def reaches(swarm: Any) -> bool:
    """Step until the keeper stands at the ball; return whether it does within four seconds."""
    for _ in range(40):
        swarm.world.step(1)
        if stands_at_the_ball(swarm):
            return True
    return False
