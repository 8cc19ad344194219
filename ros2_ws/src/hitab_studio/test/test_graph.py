"""A drawn automaton is readable: no rule lies on a state or on another rule."""

from itertools import combinations
from pathlib import Path

import pytest

from hitab_core import START, BehaviorLibrary, load_domain
from hitab_studio.graph import WIDTH, DrawnArrow, DrawnState, graph

SOURCES = Path(__file__).parents[2]
LIBRARIES = {
    SOURCES / "keepaway_world/libraries/keepaway": "keepaway",
    SOURCES / "keepaway_world/libraries/keepaway_predictive": "keepaway_predictive",
    SOURCES / "foraging_world/libraries/foraging": "foraging",
}
LEARNED = [
    (path, domain, file.name.partition(".")[0])
    for path, domain in LIBRARIES.items()
    for file in sorted(path.glob("*.yaml"))
]


def touch(one: DrawnState | DrawnArrow, other: DrawnState | DrawnArrow) -> bool:
    return (
        abs(one.x - other.x) < (one.width + other.width) / 2
        and abs(one.y - other.y) < (one.height + other.height) / 2
    )


@pytest.mark.parametrize(
    ("path", "domain", "name"), LEARNED, ids=[f"{domain}-{name}" for _, domain, name in LEARNED]
)
def test_each_rule_has_room_or_is_listed_below_the_drawing(path, domain, name):
    learned = BehaviorLibrary(path, load_domain(domain)).load()
    automaton = learned[name]
    drawing = graph(automaton, [*learned])
    assert {state.name for state in drawing.states} == {START, *automaton.labels}
    labels = [arrow for arrow in drawing.arrows if arrow.lines]
    for label in labels:
        assert not any(touch(label, state) for state in drawing.states)
        assert label.width / 2 <= label.x <= WIDTH - label.width / 2
        assert label.height / 2 <= label.y <= drawing.height - label.height / 2
    assert not any(touch(one, other) for one, other in combinations(labels, 2))
    listed = [arrow for arrow in labels if arrow.number]
    assert [arrow.number for arrow in listed] == list(range(1, len(listed) + 1))
    assert all(arrow.rule for arrow in listed)
