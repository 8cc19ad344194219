"""The table of examples fits beside the field, whatever a training looks at."""

from __future__ import annotations

from itertools import pairwise

from browsing import ONE, Person, away_from_everybody, needs_browser

FEATURES = [
    "DistanceTo(ball)",
    "DirectionTo(ball)",
    "DistanceTo(closest_taker)",
    "BallIsKickable",
]


def trains_with_four_features(swarm, person: Person) -> None:
    away_from_everybody(swarm, 5.0)
    swarm.agents.begin(ONE, "Wide", features=FEATURES, discard=True)
    person.click(f"agent-{ONE}")
    for behavior, examples in (("GoFast", 2), ("Stop", 4)):
        person.click(f"do-{behavior}")
        person.sees("counts", f"{examples} examples")
    person.click("tab-examples")
    person.sees("example-1")


@needs_browser
def test_with_four_features_an_example_and_what_to_do_with_it_stay_in_sight(swarm, person):
    trains_with_four_features(swarm, person)
    pane = person.page.locator(".pane").bounding_box()
    row = '[data-test="example-1"]'
    for part in (f"{row} td:nth-child(4)", f"{row} .acts"):
        box = person.page.locator(part).bounding_box()
        assert pane["x"] <= box["x"]
        assert box["x"] + box["width"] <= pane["x"] + pane["width"]
    boxes = [cell.bounding_box() for cell in person.page.locator(f"{row} td").all()]
    assert len(boxes) == 4 + len(FEATURES), "nothing came late: no column for that"
    for left, right in pairwise(boxes):
        assert left["x"] + left["width"] <= right["x"] + 1, "one column covers another"


@needs_browser
def test_columns_are_chosen(swarm, person):
    trains_with_four_features(swarm, person)
    person.page.click('[data-test="columns"] summary')
    for feature in FEATURES[1:]:
        person.page.uncheck(f'[data-test="column-{feature}"]', force=True)
    cells = person.page.locator('[data-test="example-1"] td')
    person.waits_until(lambda: cells.count() == 5, "one feature is left")
    wrap = person.page.locator(".table-wrap")
    assert wrap.evaluate("e => e.scrollWidth <= e.clientWidth"), "now all of it fits"
    person.page.check(f'[data-test="column-{FEATURES[3]}"]', force=True)
    person.waits_until(lambda: cells.count() == 6, "another one is back")


@needs_browser
def test_scrolling_to_an_end_moves_nothing_else(swarm, person):
    """Else scrolling a table back to its left goes back in the browser's history."""
    trains_with_four_features(swarm, person)
    free = person.page.evaluate(
        "() => [...document.querySelectorAll('html, body, #studio *')].filter(e => {"
        " const s = getComputedStyle(e);"
        " return (['auto', 'scroll'].includes(s.overflowX) || ['auto', 'scroll']"
        ".includes(s.overflowY) || e === document.body || e === document.documentElement)"
        " && s.overscrollBehaviorX === 'auto'; }).map(e => e.outerHTML.slice(0, 80))"
    )
    assert free == []
