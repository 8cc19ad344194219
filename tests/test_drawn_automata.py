"""All shipped automata are drawn so that they can be read: nothing crosses a rule or covers it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from hitab_commander import KIND_FILE, read_kind
from hitab_commander.commander_domain import commander_domain
from hitab_core import Automaton, load_domain
from hitab_core.drawing.layout import Box, crosses
from hitab_core.drawing.picture import lay_out, text_sizes
from hitab_core.library.behavior_reader import read_behavior
from hitab_studio.graph import graph

SOURCES = Path(__file__).parents[1] / "ros2_ws/src"
SHIPPED = sorted(SOURCES.glob("*_world/libraries/*/*.hfa.yaml"))


def automaton_in(path: Path) -> Automaton:
    """Read a shipped automaton; that of a commander has a domain from a file beside it."""
    kind = path.parent / KIND_FILE
    text = path.read_text(encoding="utf-8")
    stored = yaml.safe_load(text)
    domain = (
        commander_domain(read_kind(kind))
        if kind.exists()
        else load_domain(stored["domain"]["name"])
    )
    return read_behavior(text, path.name, domain).automaton


def points(path: str) -> np.ndarray:
    """Return the points of a drawn arrow, shape (n, 2)."""
    return np.array([[float(part) for part in pair.split()] for pair in path[1:].split(" L")])


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_no_arrow_crosses_a_rule_in_a_picture_or_on_a_page(path):
    automaton = automaton_in(path)
    picture = lay_out(automaton, text_sizes())
    assert picture.collisions == 0
    page = graph(automaton, [])
    labels = [arrow for arrow in page.arrows if arrow.lines]
    assert len(labels) == len(picture.words)
    for label in labels:
        box = Box(label.x, label.y, label.width, label.height)
        crossing = [a for a in page.arrows if crosses(points(a.path), box)]
        assert crossing == [], f"the rule {label.rule} is crossed"
