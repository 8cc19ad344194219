"""What the shipped examples teach is, bit for bit, what it was when they were stored."""

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from hitab_core.automaton import Automaton
from hitab_core.domain import load_domain
from hitab_core.drawing.picture import lay_out, text_sizes
from hitab_core.library.behavior_reader import read_behavior
from hitab_studio.field.graph_layout import INCH, graph

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


def shipped() -> Iterator[tuple[Path, dict[str, Any], Automaton]]:
    assert SHIPPED
    for path in SHIPPED:
        text = path.read_text(encoding="utf-8")
        stored = yaml.safe_load(text)
        domain = load_domain(stored["domain"]["name"])
        yield path, stored, read_behavior(text, path.name, domain).automaton


def test_the_stored_digest_of_each_tree_is_that_of_the_learned_one():
    for path, stored, automaton in shipped():
        learned = {state: f.digest() for state, f in automaton.transitions.items()}
        assert stored["trees"] == learned, path


def on_the_page(automaton: Automaton) -> tuple[list[Any], list[Any], float]:
    """Return words with their arrows, and all arrows; words that are numbers go without."""
    drawn = graph(automaton, [])
    paths = [re.findall(r"(-?[\d.]+) (-?[\d.]+)", arrow.path) for arrow in drawn.arrows]
    curves = [[(float(x), float(y)) for x, y in path] for path in paths]
    at = [(i, a.place) for i, a in enumerate(drawn.arrows) if a.lines and not a.number]
    return at, curves, INCH


def in_a_picture(automaton: Automaton) -> tuple[list[Any], list[Any], float]:
    panel = lay_out(automaton, text_sizes())
    return list(enumerate(panel.places)), list(panel.curves), 1.0


@pytest.mark.parametrize("drawn", [on_the_page, in_a_picture])
def test_words_stand_beside_their_own_arrow(drawn):
    def away(box: Any, curve: Any) -> float:
        return min(
            math.hypot(
                max(abs(x - box.x) - box.width / 2, 0.0), max(abs(y - box.y) - box.height / 2, 0.0)
            )
            for x, y in curve
        )

    for path, _, automaton in shipped():
        words, curves, inch = drawn(automaton)
        for i, box in words:
            own, *others = (
                away(box, c) for c in (curves[i], *curves[:i], *curves[i + 1 :]) if len(c)
            )
            assert own <= min(0.3 * inch, *others, 1e9), (path.name, i)
