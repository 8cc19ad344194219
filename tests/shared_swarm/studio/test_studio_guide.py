"""Whoever does what the studio's page says has trained a keeper that plays."""

from __future__ import annotations

import math
import random
import re
from typing import Any

from browsing import ONE, Person, away_from_everybody, entity, needs_browser
from mentions import ROOT

from hitab_core.operations import Perform

TITLE = "## Train something in two minutes"
NAME = "FetchBall"
KICKABLE_M = 1.085  # how near the ball is kicked
EPISODES = 4
A_LITTLE, FARTHER = 12.0, 40.0  # degrees beside the ball


class Guide:
    """The numbered list of the page, of which everything is done in its order."""

    def __init__(self) -> None:
        page = (ROOT / "docs/studio.md").read_text(encoding="utf-8")
        section = page.partition(TITLE)[2].partition("\n## ")[0]
        listed = re.findall(r"^\d+\. (.*(?:\n {3}.*)*)", section, re.MULTILINE)
        self.left = " ".join(" ".join(listed).split())

    def says(self, text: str) -> None:
        """Go on to what comes next on the page."""
        assert self.left.startswith(text), self.left[:200]
        self.left = self.left.removeprefix(text).lstrip()


class Trainer:
    """Somebody at the page who trains a keeper."""

    def __init__(self, person: Person, swarm: Any) -> None:
        self.person, self.swarm = person, swarm

    def press(self, key: str, name: str) -> None:
        """Press a key once it may be pressed: on a busy machine an agent may be late."""
        self.person.page.wait_for_selector(f'[data-test="{name}"]:not([aria-disabled])')
        self.person.page.keyboard.press(key)

    def command(self, behavior: str) -> None:
        button = self.person.page.locator(f'[data-test="do-{behavior}"]')
        self.press(button.locator("kbd").inner_text().lower(), f"do-{behavior}")
        self.person.page.wait_for_selector(f'[data-test="do-{behavior}"].active')

    def drag(self, name: str, x: float, y: float) -> None:
        self.person.drags(name, x, y)
        self.until(lambda: abs(entity(self.swarm, name).x - x) < 0.2)
        self.until(lambda: math.dist(self.person.place_of(name), (x, y)) < 0.2)

    def turn(self, degrees: float) -> None:
        """Drag the knob at the keeper until it looks this far to the left of the ball."""
        page, (x, y) = self.person.page, self.person.place_of(ONE)
        ball_x, ball_y = self.person.place_of("ball")
        heading = math.atan2(ball_y - y, ball_x - x) + math.radians(degrees)
        self.until(lambda: page.evaluate("window.studioField.handles.length") == 1)
        knob = page.evaluate("window.studioField.handles[0]")
        box = page.locator("canvas#field").bounding_box()
        page.mouse.move(box["x"] + knob["x"], box["y"] + knob["y"])
        page.mouse.down()
        far = self.person.on_screen(x + 2 * math.cos(heading), y + 2 * math.sin(heading))
        page.mouse.move(*far, steps=4)
        page.mouse.up()
        self.until(
            lambda: (
                abs(math.remainder(entity(self.swarm, ONE).heading - heading, math.tau))
                < math.radians(4)
            )
        )

    def await_kickable(self) -> None:
        self.person.page.wait_for_selector('.reading:has-text("BallIsKickable") .bool.yes')

    def until(self, condition: Any, seconds: float = 15.0) -> None:
        self.person.waits_until(
            lambda: self.swarm.link.spin(0.02) or condition(), "it did not happen", seconds
        )

    def stands_at_the_ball(self) -> bool:
        keeper, ball = entity(self.swarm, ONE), entity(self.swarm, "ball")
        path = self.swarm.agents.statuses[ONE].active_path
        near = math.dist((keeper.x, keeper.y), (ball.x, ball.y)) < KICKABLE_M
        return near and list(path[:1]) == ["Stop"]


@needs_browser
def test_who_does_what_the_page_says_has_a_keeper_that_reaches_the_ball(swarm, person):
    guide, trainer, world = Guide(), Trainer(person, swarm), swarm.world
    says, turn, command, drag = guide.says, trainer.turn, trainer.command, trainer.drag
    away_from_everybody(swarm, 6.0)
    world.place({"ball": {"x": 3.0, "y": 5.0}})
    world.control("resume")
    trainer.until(lambda: world.status.mode == "running")

    says("Click `keeper_1`, then **Train…**.")
    person.click(f"agent-{ONE}")
    person.click("new")
    says("Name the behavior `FetchBall`, tick the features `BallIsKickable` and")
    person.type("new-name", NAME)
    person.tick("feature-BallIsKickable")
    says("`DirectionTo(ball)`, and click **Begin**.")
    person.tick("feature-DirectionTo(ball)")
    person.click("begin")
    says("The world pauses and the frame turns amber: you decide.")
    trainer.until(lambda: world.status.mode == "paused")
    person.page.wait_for_selector('.overlay[data-mode="training"]')

    says("Drag the ball to the middle of the field, and the keeper far to the left of it.")
    drag("ball", 0.0, 0.0)
    drag(ONE, -7.0, 0.0)
    says("Drag any player beside it out of the way.")
    for i, name in enumerate(("keeper_2", "keeper_3", "taker_1", "taker_2")):
        there = entity(swarm, name)
        if math.dist((there.x, there.y), (-7.0, 0.0)) < 3.0:
            drag(name, 8.0, 6.0 - 3.0 * i)
    says("A keeper runs where it looks, so its heading matters: drag the small knob at the keeper")
    says("until it looks away from the ball.")
    turn(150.0)
    says("Press the key on the button `TurnToBall`.")
    command("TurnToBall")
    says("*Just recorded* shows the example with the keeper's percept, and below it the default")
    says("example: otherwise, continue turning.")
    person.sees("counts", "2 examples")
    texts = person.page.locator('[data-test="recorded"]').all_inner_texts()
    assert ["default" in text for text in texts] == [False, True]
    assert all("DirectionTo(ball)" in text and "TurnToBall" in text for text in texts)

    says(
        "Turn the keeper until it looks almost at the ball, a little to the left of it, and press"
    )
    says("the key of `GoFast`. Turn it farther to the left and press the key of `TurnToBall`.")
    says("Do the same on the other side: a little to the right of the ball `GoFast`, farther to")
    says("the right `TurnToBall`.")
    for side in (1.0, -1.0):
        for degrees, behavior in ((A_LITTLE, "GoFast"), (FARTHER, "TurnToBall")):
            turn(side * degrees)
            command(behavior)
    says("Drag the keeper to the ball, until *Perceives now* answers `BallIsKickable` with yes,")
    says("and press the key of `Stop`.")
    drag(ONE, -0.7, 0.0)
    trainer.await_kickable()
    command("Stop")
    says("Drag the ball far behind the keeper: `TurnToBall`.")
    drag("ball", -8.0, 0.0)
    command("TurnToBall")
    says("Turn the keeper to the ball: `GoFast`. Drag it to the ball: `Stop`.")
    turn(0.0)
    command("GoFast")
    drag(ONE, -7.3, 0.0)
    trainer.await_kickable()
    command("Stop")
    person.sees("counts", "18 examples")

    says("Press `T`: now the learned automaton decides, and the frame turns teal.")
    trainer.press("t", "toggle")
    person.page.wait_for_selector('.overlay[data-mode="testing"]')
    says("Press `R` for a new episode and Space to let the world run.")
    before = world.status.episode
    trainer.press("r", "pause")
    trainer.until(lambda: world.status.episode > before)
    trainer.until(lambda: list(swarm.agents.statuses[ONE].active_path) == ["Start"])
    world.control("pace", pace="realtime", factor=0.25)  # this machine may be busy
    trainer.press(" ", "pause")
    says("The keeper turns to the ball, runs to it and stops.")
    trainer.until(trainer.stands_at_the_ball, 60.0)
    says("When a taker has won the ball, the next episode begins, and the keeper does the same")
    says("again.")
    world.control("pace", pace="realtime", factor=1.0)
    episode = world.status.episode
    trainer.until(lambda: trainer.stands_at_the_ball() and world.status.episode > episode, 60.0)
    world.control("pause")

    says(
        "**Save…** shows which features will be kept and which are trimmed, and lets you turn a "
        "target into a"
    )
    says("parameter.")
    person.click("save")
    person.sees("preview", NAME)
    assert "becomes" in person.page.inner_text(".dialog")
    person.page.evaluate(
        "new MutationObserver(() => { window.wasEmpty ||="
        " !!document.querySelector('[data-test=empty-library]'); })"
        ".observe(document.body, { childList: true, subtree: true })"
    )
    person.click("save-now")
    person.sees("message", "saved")
    says("**Distribute…** sends the behavior to the others and shows each acknowledgement.")
    person.click("distribute")
    person.click("distribute-now")
    assert not person.page.evaluate("window.wasEmpty"), "what was saved is there, or read"
    for name in ("keeper_2", "keeper_3"):
        person.sees("acks", f"{name} has it")
    person.click("done")
    assert guide.left == ""

    world.control("pace", pace="lockstep")
    swarm.agents.do(ONE, Perform(NAME))
    random_ = random.Random(3)
    corners = {"keeper_2": (9, 9), "keeper_3": (9, -9), "taker_1": (-9, 9), "taker_2": (-9, -9)}
    for _ in range(EPISODES):
        things = {
            name: {"x": random_.uniform(-far, far), "y": random_.uniform(-far, far)}
            for name, far in ((ONE, 8.0), ("ball", 4.0))  # the takers must not be there first
        }
        things[ONE]["heading"] = random_.uniform(-math.pi, math.pi)
        things |= {name: {"x": x, "y": y} for name, (x, y) in corners.items()}
        still = {name: {"vx": 0.0, "vy": 0.0, **place} for name, place in things.items()}
        world.shown(world.place(still, new_episode=True))
        assert any(world.step(1) and trainer.stands_at_the_ball() for _ in range(40)), things
    world.control("pace", pace="realtime", factor=1.0)
