"""Everything in the field is found, chosen, moved and turned: with a mouse, a finger or keys."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import Any

import pytest
from browsing import ONE, TWO, Person, away_from_everybody, entity, needs_browser, visitor


def field(person: Person, what: str) -> Any:
    return person.page.evaluate(f"(() => {{ const f = window.studioField; return {what}; }})()")


def shown_at(person: Person, name: str, x: float, y: float) -> None:
    person.waits_until(
        lambda: math.dist(person.place_of(name), (x, y)) < 0.2, f"{name} is shown there"
    )


# -- seeing -----------------------------------------------------------------------------------


@needs_browser
def test_no_name_lies_on_another_one(swarm, person):
    away_from_everybody(swarm, 5.0)
    crowd = {
        name: {"x": 0.1 * i, "y": 0.15 * i, "vx": 0.0, "vy": 0.0}
        for i, name in enumerate(("keeper_1", "keeper_2", "keeper_3", "taker_1", "taker_2"))
    }
    swarm.world.shown(swarm.world.place(crowd))
    shown_at(person, "taker_2", 0.4, 0.6)
    person.waits_until(lambda: len(field(person, "f.labels")) >= 2, "some are named")
    for (ax, ay, aw, ah), (bx, by, bw, bh) in combinations(field(person, "f.labels"), 2):
        assert ax >= bx + bw or bx >= ax + aw or ay >= by + bh or by >= ay + ah


@needs_browser
@pytest.mark.parametrize("heading", [-math.pi / 2, -math.pi / 4, 0.0, math.pi / 2])
def test_a_name_makes_way_for_the_knob_that_turns_a_thing(swarm, person, heading):
    away_from_everybody(swarm, 6.0)
    swarm.world.shown(swarm.world.place({ONE: {"x": -6.0, "y": 0.0, "heading": heading}}))
    shown_at(person, ONE, -6.0, 0.0)
    person.click(f"agent-{ONE}")
    person.waits_until(lambda: field(person, "f.handles.length") == 1, "it has a knob")
    index = field(person, f"f.index.get('{ONE}')")
    turned = f"Math.abs(f.now.places[3 * {index} + 2] - {heading}) < 0.05"
    person.waits_until(lambda: field(person, turned), "it is shown as it was turned")
    person.page.wait_for_timeout(400)  # it is drawn between two moments until then
    knob, labels = field(person, "f.handles[0]"), field(person, "f.labels")
    assert len(labels) == 5
    for x, y, width, height in labels:
        away = (
            max(x - knob["x"], 0.0, knob["x"] - x - width),
            max(y - knob["y"], 0.0, knob["y"] - y - height),
        )
        assert math.hypot(*away) >= 4.0, "the knob lies on a name"


@needs_browser
def test_what_is_out_of_sight_has_an_arrow_that_leads_to_it(swarm, person):
    away_from_everybody(swarm, 6.0)
    shown_at(person, ONE, -6.0, 0.0)
    field(person, "f.zoom(6, ...f.toScreen(8, 9))")
    index = field(person, f"f.index.get('{ONE}')")
    person.waits_until(
        lambda: any(a["i"] == index for a in field(person, "f.arrows")), "it has an arrow"
    )
    arrow = next(a for a in field(person, "f.arrows") if a["i"] == index)
    box = person.page.locator("canvas#field").bounding_box()
    assert 0 < arrow["x"] < box["width"]
    assert 0 < arrow["y"] < box["height"]
    person.page.mouse.click(box["x"] + arrow["x"], box["y"] + arrow["y"])
    person.sees("banner", ONE)
    x, y = person.on_screen(*person.place_of(ONE))
    assert box["x"] < x < box["x"] + box["width"]
    assert box["y"] < y < box["y"] + box["height"]


@needs_browser
def test_the_field_stays_where_it_is_when_an_agent_is_chosen_and_trained(swarm, person):
    away_from_everybody(swarm, 6.0)
    shown_at(person, TWO, 8.0, 8.0)
    before = field(person, "[f.width, f.height, f.view.scale, f.view.x, f.view.y]")
    person.page.mouse.click(*person.on_screen(*person.place_of(TWO)))
    person.sees("banner", TWO)
    person.sees("behaviors")
    swarm.agents.begin(TWO, "Still", features=["DistanceTo(ball)"], discard=True)
    person.sees("mode", "Training")
    person.page.wait_for_timeout(400)
    assert field(person, "[f.width, f.height, f.view.scale, f.view.x, f.view.y]") == before


@needs_browser
def test_the_field_grows_again_after_notices_over_it_have_gone(swarm, person):
    person.click(f"agent-{TWO}")
    person.sees("behaviors")
    before = field(person, "f.view.scale")
    high = "const style = document.createElement('style'); style.id = 'high';"
    high += " style.textContent = '.notices { min-height: 160px }'; document.head.append(style)"
    person.page.evaluate(f"() => {{ {high} }}")
    person.waits_until(lambda: field(person, "f.view.scale") < before, "there is room for them")
    person.page.evaluate("() => document.getElementById('high').remove()")
    person.waits_until(lambda: field(person, "f.view.scale") == before, "it is as large as before")


@needs_browser
def test_more_rows_of_behaviors_get_room_once_the_pointer_has_left_the_field(swarm, person):
    away_from_everybody(swarm, 6.0)
    shown_at(person, TWO, 8.0, 8.0)
    person.page.mouse.click(*person.on_screen(*person.place_of(TWO)))
    person.sees("behaviors")
    before = field(person, "f.view.scale")
    # By a style sheet: an attribute would go when the server describes the overlay again.
    person.page.add_style_tag(content=".deck { min-height: 150px }")
    person.page.wait_for_timeout(700)
    assert field(person, "f.view.scale") == before
    person.page.hover(f'[data-test="agent-{TWO}"]')
    person.waits_until(lambda: field(person, "f.view.scale") < before, "there is room")
    deck = person.page.locator(".deck").bounding_box()
    assert person.on_screen(0.0, -10.0)[1] < deck["y"]


@needs_browser
def test_among_many_robots_differ_from_obstacles_in_color_and_shape(person):
    """Few pixels are left to each: a robot is an arrowhead, and an obstacle stays round."""
    here, behind = person.page.evaluate(
        """async () => {
            const f = window.studioField;
            const names = [...Array(200).keys()].map((i) => `thing_${i}`);
            const look = { shape: "disc", labelled: false, opacity: 1, layer: 0 };
            f.take({
                t: "roster", size: [20, 20], names, radii: names.map(() => 1), legend: [],
                kinds: names.map((_, i) => (i === 1 ? "obstacle" : "robot")),
                looks: {
                    robot: { ...look, color: "#5c7ea8", faces: true },
                    obstacle: { ...look, color: "#8b939d", faces: false },
                },
            });
            const places = new Float32Array(600).fill(9);
            places.set([0, 0, 0, 5, 0, 0]); // a robot and an obstacle, that look to the right
            const n = names.length;
            f.take({
                t: "frame", cycle: 1, n, places, modes: new Uint8Array(n),
                colors: new Uint8Array(n).fill(255),
            });
            for (let i = 0; i < 3; i++) await new Promise(requestAnimationFrame);
            const pixel = (x, y) => {
                const [px, py] = f.toScreen(x, y).map((p) => Math.round(p * f.ratio));
                return [...f.context.getImageData(px, py, 1, 1).data].join();
            };
            return [[pixel(0.3, 0), pixel(5, 0)], [pixel(-0.9, 0), pixel(4.1, 0)]];
        }"""
    )
    assert here[0] != here[1], "they have the same color"
    assert behind[0] != here[0], "the robot is round"
    assert behind[1] == here[1], "the obstacle is not"


# -- fingers ----------------------------------------------------------------------------------


class Finger:
    """A finger on the page."""

    def __init__(self, page: Any) -> None:
        self._page = page
        self._cdp = page.context.new_cdp_session(page)

    def _send(self, kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": x, "y": y} for x, y in places]
        self._cdp.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def taps(self, place: tuple[float, float]) -> None:
        self._send("touchStart", place)
        self._send("touchEnd")

    def drags(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        self._send("touchStart", start)
        for part in (0.25, 0.5, 0.75, 1.0):
            x, y = (a + part * (b - a) for a, b in zip(start, end, strict=True))
            self._send("touchMove", (x, y))
        self._send("touchEnd")

    def holds(self, place: tuple[float, float], until: Any) -> None:
        self._send("touchStart", place)
        until()
        self._send("touchEnd")


@pytest.fixture
def tablet(chrome, url) -> Iterator[Person]:
    """Somebody with a tablet that is held upright."""
    with visitor(chrome, url, viewport={"width": 820, "height": 1180}, has_touch=True) as someone:
        yield someone


@needs_browser
def test_a_finger_chooses_drags_and_turns(swarm, tablet):
    away_from_everybody(swarm, 6.0)
    shown_at(tablet, ONE, -6.0, 0.0)
    finger = Finger(tablet.page)
    x, y = tablet.on_screen(*tablet.place_of(ONE))
    finger.taps((x + 10, y + 10))  # beside it, as fingers do
    tablet.sees("banner", ONE)
    finger.drags(tablet.on_screen(*tablet.place_of(ONE)), tablet.on_screen(-3.0, 4.0))
    tablet.waits_until(lambda: abs(entity(swarm, ONE).x + 3.0) < 0.3, "it was moved")
    shown_at(tablet, ONE, entity(swarm, ONE).x, entity(swarm, ONE).y)
    tablet.waits_until(lambda: field(tablet, "f.handles.length") == 1, "it has a knob")
    box = tablet.page.locator("canvas#field").bounding_box()
    knob = field(tablet, "f.handles[0]")
    start = (box["x"] + knob["x"], box["y"] + knob["y"])
    place = entity(swarm, ONE)
    finger.drags(start, tablet.on_screen(place.x, place.y + 5.0))
    tablet.waits_until(
        lambda: abs(entity(swarm, ONE).heading - math.pi / 2) < 0.2, "it was turned"
    )
    assert entity(swarm, ONE).x == pytest.approx(place.x, abs=0.05)


@needs_browser
def test_the_knob_of_what_is_chosen_turns_it_although_it_lies_on_another_thing(swarm, person):
    away_from_everybody(swarm, 6.0)
    shown_at(person, ONE, -6.0, 0.0)
    person.click(f"agent-{ONE}")
    person.waits_until(lambda: field(person, "f.handles.length") == 1, "it has a knob")
    knob = "f.toField(f.handles[0].x, f.handles[0].y)"
    x, y = field(person, knob)
    swarm.world.shown(swarm.world.place({"taker_1": {"x": x, "y": y}}))
    shown_at(person, "taker_1", x, y)
    box = person.page.locator("canvas#field").bounding_box()
    at = field(person, "f.handles[0]")
    person.page.keyboard.down("Shift")  # chooses the other one, too
    person.page.mouse.click(box["x"] + at["x"], box["y"] + at["y"])
    person.page.keyboard.up("Shift")
    person.waits_until(lambda: len(field(person, "[...f.chosen]")) == 2, "both are chosen")
    person.click(f"agent-{ONE}")
    person.waits_until(lambda: field(person, "[...f.chosen]") == [ONE], "one is chosen")
    at = field(person, "f.handles[0]")
    person.page.mouse.move(box["x"] + at["x"], box["y"] + at["y"])
    person.page.mouse.down()
    place = entity(swarm, ONE)
    person.page.mouse.move(*person.on_screen(place.x, place.y + 5.0), steps=5)
    person.page.mouse.up()
    person.waits_until(
        lambda: abs(entity(swarm, ONE).heading - math.pi / 2) < 0.2, "it was turned"
    )
    assert entity(swarm, "taker_1").x == pytest.approx(x, abs=0.3)


@needs_browser
def test_a_finger_that_stays_chooses_several(swarm, tablet):
    away_from_everybody(swarm, 6.0)
    shown_at(tablet, ONE, -6.0, 0.0)
    shown_at(tablet, TWO, 8.0, 8.0)
    finger = Finger(tablet.page)
    finger.taps(tablet.on_screen(*tablet.place_of(ONE)))
    tablet.sees("banner", ONE)
    finger.holds(
        tablet.on_screen(*tablet.place_of(TWO)),
        lambda: tablet.waits_until(lambda: field(tablet, "f.chosen.size") == 2, "both are chosen"),
    )
    assert set(field(tablet, "[...f.chosen]")) == {ONE, TWO}


@needs_browser
def test_on_a_tablet_list_connection_and_episode_stay_in_sight(swarm, tablet):
    tablet.click(f"agent-{ONE}")
    tablet.sees("banner", ONE)
    for part in (f'[data-test="agent-{ONE}"]', ".where", ".when", ".pane", "canvas#field"):
        box = tablet.page.locator(part).bounding_box()
        assert box is not None, part
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 820
        assert box["y"] + box["height"] <= 1180


# -- the keyboard -----------------------------------------------------------------------------


@needs_browser
def test_the_keyboard_chooses_moves_and_turns_things(swarm, person):
    away_from_everybody(swarm, 6.0)
    shown_at(person, ONE, -6.0, 0.0)
    keys = person.page.keyboard
    person.page.focus("canvas#field")
    for _ in range(len(field(person, "f.roster.names"))):
        if field(person, "[...f.chosen]") == [ONE]:
            break
        before = field(person, "[...f.chosen]")
        keys.press(">")
        person.waits_until(lambda b=before: field(person, "[...f.chosen]") != b, "the next one")
    assert ONE in person.page.inner_text("#field-told")
    person.sees("banner", ONE)
    heading = entity(swarm, ONE).heading
    for key in ("ArrowRight", "ArrowRight", "ArrowUp", ","):
        keys.press(key)
    person.waits_until(lambda: abs(entity(swarm, ONE).x + 5.0) < 0.1, "it was moved")
    person.waits_until(lambda: abs(entity(swarm, ONE).y - 0.5) < 0.1, "it was moved up")
    person.waits_until(
        lambda: abs(entity(swarm, ONE).heading - heading - math.pi / 12) < 0.05, "it was turned"
    )


@needs_browser
def test_keys_that_scroll_scroll_and_choose_nobody_else(swarm, person):
    person.page.set_viewport_size({"width": 1280, "height": 400})
    person.click(f"agent-{ONE}")
    swarm.agents.begin(ONE, "Long", features=["DistanceTo(ball)"], discard=True)
    person.click("do-GoFast")
    person.sees("counts", "2 examples")
    pane = "document.querySelector('.side .pane')"
    person.waits_until(
        lambda: person.page.evaluate(f"{pane}.scrollHeight > {pane}.clientHeight + 50"), "long"
    )
    person.page.focus("canvas#field")
    for key, scrolled in (("PageDown", True), ("PageUp", False), ("End", True), ("Home", False)):
        person.page.keyboard.press(key)
        person.waits_until(
            lambda s=scrolled: (person.page.evaluate(f"{pane}.scrollTop") > 0) is s, key
        )
    assert ONE in person.text("banner")
    person.page.keyboard.press("]")
    person.sees("banner", TWO)
    person.page.keyboard.press("[")
    person.sees("banner", ONE)
    swarm.agents.discard(ONE)
