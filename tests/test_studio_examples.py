"""The table of examples fits beside the field, whatever a training looks at."""

from __future__ import annotations

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
