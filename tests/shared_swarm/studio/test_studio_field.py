"""Everything in the field is found, chosen, moved and turned: with a mouse, a finger or keys."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest
from browsing import ONE, Person, away_from_everybody, entity, needs_browser, visitor

from hitab_core.operations import BeginTraining, Command, DiscardTraining


def field(person: Person, what: str) -> Any:
    return person.page.evaluate(f"(() => {{ const f = window.studioField; return {what}; }})()")


def shown_at(person: Person, name: str, x: float, y: float) -> None:
    person.waits_until(
        lambda: math.dist(person.place_of(name), (x, y)) < 0.2, f"{name} is shown there"
    )


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
        keys.press("PageDown")
        person.waits_until(lambda b=before: field(person, "[...f.chosen]") != b, "the next one")
    assert ONE in person.page.inner_text("#field-report")
    person.sees("banner", ONE)
    heading = entity(swarm, ONE).heading
    for key in ("ArrowRight", "ArrowRight", "ArrowUp", "Alt+ArrowLeft"):
        keys.press(key)
    person.waits_until(lambda: abs(entity(swarm, ONE).x + 5.0) < 0.1, "it was moved")
    person.waits_until(lambda: abs(entity(swarm, ONE).y - 0.5) < 0.1, "it was moved up")
    person.waits_until(
        lambda: abs(entity(swarm, ONE).heading - heading - math.pi / 12) < 0.05, "it was turned"
    )


# -- small screens ----------------------------------------------------------------------------

COVERED = """
async () => {
  const all = [...document.querySelectorAll("#studio button, #studio select, #studio input")];
  const found = [];
  for (const it of all) {
    if (!it.checkVisibility({ visibilityProperty: true }) || !it.isConnected) continue;
    it.scrollIntoView({ block: "nearest", inline: "center", behavior: "instant" });
    const box = it.getBoundingClientRect();
    if (!box.width || !box.height) continue;
    const top = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
    if (!it.contains(top)) found.push((it.dataset.test ?? it.outerHTML.slice(0, 90)));
  }
  return found;
}
"""


@pytest.fixture
def trained(swarm: Any) -> Iterator[None]:
    """A keeper in training, with examples: more is on the page than otherwise."""
    away_from_everybody(swarm, 6.0)
    features = ["BallIsKickable", "DirectionTo(ball)", "DistanceTo(ball)"]
    swarm.agents.do(ONE, BeginTraining("Small", features=features, discard=True))
    for behavior in ("TurnToBall", "GoFast", "TurnToBall"):
        swarm.agents.do(ONE, Command(behavior))
    yield
    swarm.agents.do(ONE, DiscardTraining())


@needs_browser
@pytest.mark.parametrize(
    ("width", "height"), [(390, 844), (844, 390), (800, 600), (820, 1180), (1440, 900)]
)
def test_nothing_covers_what_there_is_to_press_and_the_field_is_seen(
    trained, chrome, url, width, height
):
    size = {"width": width, "height": height}
    with visitor(chrome, url, viewport=size, has_touch=width < 1000) as someone:
        someone.click(f"agent-{ONE}")
        someone.sees("behaviors")
        for tab in ("teach", "learned", "examples"):
            someone.click(f"tab-{tab}")
            someone.page.wait_for_selector(f'[data-test="tab-{tab}"][aria-selected="true"]')
            assert someone.page.evaluate(COVERED) == []
        if width == 1440:
            wide = "e => e.scrollWidth > e.clientWidth"
            assert not someone.page.locator(".table-wrap").evaluate(wide), "no column is cut off"
        if min(width, height) > 600:
            return
        chips = someone.page.locator('[data-test="behaviors"] .chips')
        tops = {
            round(box["y"]) for b in chips.locator("button").all() if (box := b.bounding_box())
        }
        assert len(tops) == 1, "the keys are in one row"
        deck, banner = (
            someone.page.locator(f'[data-test="{name}"]').bounding_box()
            for name in ("behaviors", "banner")
        )

        def is_free() -> bool:
            corners = [someone.on_screen(x, y)[1] for x, y in ((-10.0, 10.0), (10.0, -10.0))]
            return banner["y"] + banner["height"] <= corners[0] and corners[1] <= deck["y"]

        someone.waits_until(is_free, "something covers the field")
        stage = someone.page.locator("#stage").bounding_box()
        assert stage["height"] > 0.5 * height


@needs_browser
def test_things_that_touch_bear_each_its_own_name(swarm, person):
    away_from_everybody(swarm, 6.0)
    both = {"taker_1": (5.0, 0.0), "taker_2": (5.6, 0.0)}
    swarm.world.shown(swarm.world.place({name: {"x": x, "y": y} for name, (x, y) in both.items()}))
    shown_at(person, "taker_2", 5.6, 0.0)
    person.waits_until(
        lambda: both.keys() <= {name["name"] for name in field(person, "f.named")},
        "both are named",
    )
    boxes = field(person, "f.named")
    for i, one in enumerate(boxes):
        for other in boxes[:i]:
            apart = abs(one["x"] - other["x"]) >= one["half"] + other["half"]
            assert apart or abs(one["y"] - other["y"]) >= 13, (one, other)
