"""What the shipped examples teach is, bit for bit, what it was when they were stored."""

from pathlib import Path

import yaml

from hitab_core.domain import load_domain
from hitab_core.library.behavior_reader import read_behavior

SOURCES = Path(__file__).parents[1] / "ros2_ws/src"
OF_COMMANDERS = (
    *("captain", "foraging_company", "foraging_roles", "foraging_squad", "half_field_captain"),
)
# Their domains come from descriptions.
SHIPPED = [
    path
    for path in sorted(SOURCES.glob("*_world/libraries/*/*.hfa.yaml"))
    if path.parent.name not in OF_COMMANDERS
]


def test_the_stored_digest_of_each_tree_is_that_of_the_learned_one():
    assert SHIPPED
    for path in SHIPPED:
        text = path.read_text(encoding="utf-8")
        stored = yaml.safe_load(text)
        automaton = read_behavior(text, path.name, load_domain(stored["domain"]["name"])).automaton
        learned = {state: f.digest() for state, f in automaton.transitions.items()}
        assert stored["trees"] == learned, path
