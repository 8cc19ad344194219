"""Whoever does only what the tutorial marks has trained a keeper that performs."""

from __future__ import annotations

import math
from typing import Any

from browsing import (
    ONE,
    Person,
    away_from_everybody,
    entity,
    needs_browser,
    present_training,
    visitor,
)

from hitab_core.operations import DiscardTraining

NAME = "FetchBall"
PRESSES_MAX = 80


LOOK = """() => {
  const middle = (name) => {
    const it = document.querySelector(`[data-test="${name}"]`);
    if (!it || it.hidden) return null;
    const box = it.getBoundingClientRect();
    return [box.x + box.width / 2, box.y + box.height / 2];
  };
  const { step, of } = document.querySelector('[data-test="tutorial-ring"]').dataset;
  return { step, of, ring: middle("tutorial-ring"), spot: middle("tutorial-spot") };
}"""
"""Returns the step, the name of what is in the ring, and where the rings are."""

FREE = """() => {
  const { of } = document.querySelector('[data-test="tutorial-ring"]').dataset;
  const wanted = of ? `[data-test="${of}"]` : "#field";
  return ["tutorial-ring", "tutorial-spot"].every((name) => {
    const it = document.querySelector(`[data-test="${name}"]`);
    if (it.hidden) return true;
    const { x, y, width, height } = it.getBoundingClientRect();
    return document.elementFromPoint(x + width / 2, y + height / 2)?.closest(wanted);
  });
}"""
"""Returns whether a person can press what is in the rings."""


class Follower:
    """Somebody who reads nothing but the card, and presses and drags what is marked."""

    def __init__(self, person: Person, swarm: Any) -> None:
        self.person, self.page, self.swarm = person, person.page, swarm
        self.done: list[str] = []

    def look(self) -> dict[str, Any]:
        """Return what the tutorial shows at this moment."""
        self.swarm.link.spin(0.02)
        return dict(self.page.evaluate(LOOK))

    def follow(self, until: str) -> None:
        """Do what is marked until a step is reached."""
        before: tuple[str, ...] = ()
        while (shown := self.look())["step"] != until:
            marked = (shown["step"], shown["of"])
            assert marked[0] != "end", self.done
            if not shown["ring"] or marked == before or marked[0] == "watch":
                self.page.wait_for_timeout(50)
                continue
            self.person.waits_until(lambda: self.page.evaluate(FREE), f"covered: {marked}")
            shown = self.look()
            if shown["ring"] and (shown["step"], shown["of"]) == marked:
                assert len(self.done) < PRESSES_MAX, self.done
                self.done.append(shown["step"])
                self._do(shown)
                before = marked

    def _do(self, shown: dict[str, Any]) -> None:
        mouse = self.page.mouse
        if shown["spot"]:
            mouse.move(*shown["ring"])
            mouse.down()
            mouse.move(*shown["spot"], steps=4)
            mouse.up()
        elif shown["of"] == "new-name":
            self.person.type("new-name", NAME)
        elif shown["of"].startswith("feature-"):
            self.person.tick(shown["of"])
        else:
            self.page.wait_for_selector(f'[data-test="{shown["of"]}"]:not([aria-disabled])')
            self.person.click(shown["of"])


def apart(swarm: Any) -> None:
    away_from_everybody(swarm, 6.0)
    swarm.world.control("pause")


@needs_browser
def test_who_presses_only_what_is_marked_saves_a_behavior_that_performs(swarm, person):
    apart(swarm)
    person.click("tutorial-start")
    person.sees("tutorial-text", "Choose a keeper")
    follower = Follower(person, swarm)

    follower.follow("arrange-3")
    assert "slip" in follower.done
    assert follower.done.count("mend") == 1, follower.done
    person.waits_until(lambda: len(present_training(swarm).examples) == 6, "two for each command")

    # Left, and taken up after a reload; a training that was discarded begins again.
    person.click("tutorial-leave")
    person.does_not_see("tutorial")
    person.page.reload()
    person.sees_field()
    person.page.keyboard.press("?")
    person.click("tutorial-open")
    person.sees("tutorial-text", "Choose a keeper")
    follower.follow("arrange-3")
    swarm.agents.do(ONE, DiscardTraining())
    person.sees("tutorial-text", "Press Train")
    person.page.reload()
    person.sees_field()
    person.sees("tutorial-text", "Choose a keeper")  # it was open

    follower.done.clear()
    follower.follow("end")
    assert person.text("mode") == "Performing"
    person.sees("tutorial-text", "Done")
    person.click("tutorial-leave")
    person.does_not_see("tutorial")
    person.page.reload()
    person.sees_field()
    person.page.wait_for_selector("[data-tutorial*=finished]", state="attached")
    assert person.page.locator('[data-test="tutorial-start"]').count() == 0

    def at_the_ball() -> bool:
        swarm.link.spin(0.02)
        keeper, ball = entity(swarm, ONE), entity(swarm, "ball")
        return math.dist((keeper.x, keeper.y), (ball.x, ball.y)) < 1.085

    swarm.world.control("pace", pace="lockstep")
    for x, heading in ((6.0, 0.0), (-6.0, 2.0), (-5.0, -2.0)):
        away_from_everybody(swarm, 6.0)
        swarm.world.shown(swarm.world.place({ONE: {"x": x, "y": 0.0, "heading": heading}}))
        assert any(swarm.world.step(1) and at_the_ball() for _ in range(60)), (x, heading)
    swarm.world.control("pace", pace="realtime", factor=1.0)


@needs_browser
def test_in_a_small_window_nothing_covers_what_is_marked(swarm, chrome, url):
    apart(swarm)
    with visitor(chrome, url, viewport={"width": 800, "height": 600}) as someone:
        someone.click("tutorial-start")
        follower = Follower(someone, swarm)
        follower.follow("arrange-2")
        assert {"begin", "room", "command-0", "arrange-1", "slip", "mend"} <= {*follower.done}
        swarm.agents.do(ONE, DiscardTraining())


@needs_browser
def test_the_tutorial_begins_again_when_a_person_says_so(swarm, person):
    apart(swarm)
    person.click("tutorial-start")
    person.sees("tutorial-text", "Choose a keeper")
    passed = '[data-tutorial*="slip"]'
    person.page.evaluate("""() => studioTell("tutorial-skip", { name: "slip" })""")
    person.page.wait_for_selector(passed, state="attached")
    person.page.keyboard.press("?")
    person.click("tutorial-again")
    person.sees("tutorial-text", "Choose a keeper")
    person.page.wait_for_selector(passed, state="detached")
