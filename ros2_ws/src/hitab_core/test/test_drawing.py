from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hitab_core.automaton import Automaton
from hitab_core.drawing.graph import arrows
from hitab_core.drawing.layout import (
    Box,
    bend_arrows,
    crosses,
    curve,
    place_words,
    state_boxes,
)
from hitab_core.drawing.picture import draw_automata
from hitab_core.drawing.text import automaton_as_text
from hitab_core.errors import HitabError
from hitab_core.transition_function import HandWritten
from hitab_core.use import Use

Teach = Callable[..., Automaton]


def test_a_text_shows_states_transitions_as_rules_and_trees(
    keepaway: Automaton,
) -> None:
    assert automaton_as_text(keepaway) == "\n".join(
        [
            "Keepaway",
            "  features: BallIsKickable, Done",
            "  examples: 7",
            "",
            "  Start",
            "    -> Control always",
            "",
            "  Control",
            "    stays: not Done",
            "    -> Stop: Done",
            "",
            "  Stop",
            "    -> Control: BallIsKickable",
            "    stays: not BallIsKickable",
            "",
            "  tree of Control",
            "    not Done: Control (3)",
            "    Done: Stop (1)",
            "",
            "  tree of Stop",
            "    not BallIsKickable: Stop (1)",
            "    BallIsKickable: Control (1)",
        ]
    )


def test_a_text_shows_parameters_flags_states_without_examples_and_odds(teach: Teach) -> None:
    automaton = teach(
        "Visit",
        ["DistanceTo(A)"],
        [("Start", [1], "GoTo(A)"), ("Start", [1], "Stop"), ("GoTo(A)", [0.5], "Done")],
        parameters=["A"],
        defaults=False,
    )
    text = automaton_as_text(automaton, trees=False)
    assert text.startswith("Visit(A)\n")
    assert "-> GoTo(A) always (0.5)" in text
    assert "  Stop\n    stays" in text
    assert "  Done\n    raises the flag, then -> Start" in text


def test_arrows_lead_from_flags_back_to_start_and_tell_each_way(control: Automaton) -> None:
    found = {(arrow.source, arrow.target): arrow for arrow in arrows(control)}
    assert found["Done", "Start"].leaves_flag
    assert found["Approach", "Approach"].is_loop
    assert str(found["Approach", "Kick"].ways[0]) == "BallIsKickable"
    assert str(found["Start", "Approach"].ways[0]) == "always"


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_automata_are_drawn_side_by_side_into_a_file(
    tmp_path: Path, approach: Automaton, control: Automaton, ending: str
) -> None:
    path = draw_automata([approach, control], tmp_path / f"all.{ending}")
    head = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[ending]
    assert path.read_bytes().startswith(head)
    if ending == "svg":
        words = set(re.findall(r">([^<>\n]+)</text>", path.read_text()))
        assert {"Start", "Approach", "Control", "Kick", "GoTo(goal)", "Done"} <= words
        assert "BallIsKickable" in words


def test_the_same_automaton_gives_the_same_picture(tmp_path: Path, keepaway: Automaton) -> None:
    one = draw_automata([keepaway], tmp_path / "one.svg").read_bytes()
    assert draw_automata([keepaway], tmp_path / "two.svg").read_bytes() == one


def test_automata_without_rules_and_with_many_states_can_be_drawn(
    tmp_path: Path, teach: Teach
) -> None:
    empty = Automaton("Empty", (), (), {})
    written = Automaton("Fixed", (Use("Stop"),), (), {"Start": HandWritten(lambda: "Stop")})
    states = ["GoFast", "GoSlow", "Stop", "Kick", "GoTo(ball)", "GoTo(goal)", "Patrol", "Failed"]
    many = teach(
        "Many",
        ["DistanceTo(ball)"],
        [
            (s, [i + j], t)
            for i, s in enumerate(["Start", *states[:-1]])
            for j, t in enumerate(states)
            if s != t and (i + j) % 3
        ],
    )
    path = draw_automata([empty, written, many], tmp_path / "all.png")
    assert path.stat().st_size > 10_000
    assert "a function without rules decides" in automaton_as_text(written)


def test_a_picture_that_cannot_be_drawn_is_named(tmp_path: Path, keepaway: Automaton) -> None:
    with pytest.raises(HitabError, match="there is no automaton to draw"):
        draw_automata([], tmp_path / "none.png")
    with pytest.raises(HitabError, match="cannot be drawn"):
        draw_automata([keepaway], tmp_path / "picture.doc")
    with pytest.raises(HitabError, match="cannot be drawn"):
        draw_automata([keepaway], tmp_path / "missing" / "picture.png")


@pytest.mark.parametrize("n", [3, 5, 7])
def test_words_cover_neither_states_nor_words_nor_the_edge(n: int) -> None:
    states = [f"State{i}" for i in range(n)]
    pairs = [(a, b) for a in states for b in states if (ord(a[-1]) + 2 * ord(b[-1])) % 3 == 1]
    pairs = [pair for pair in pairs if pair[0] != pair[1]]
    width, height = 3.5 + n, 3.0 + 0.6 * n
    boxes = state_boxes(states, width, height, lambda text: (0.6, 0.15), margin=0.6)
    bends = bend_arrows(boxes, pairs, width, height)
    curves = [curve(boxes[a], boxes[b], bend) for (a, b), bend in zip(pairs, bends, strict=True)]
    words = place_words([(1.0, 0.15)] * len(pairs), curves, list(boxes.values()), width, height)
    everything = [*boxes.values(), *words]
    for i, one in enumerate(everything):
        assert abs(one.x) + one.width / 2 <= width / 2 + 1e-9
        assert abs(one.y) + one.height / 2 <= height / 2 + 1e-9
        for other in everything[:i]:
            apart_x = abs(one.x - other.x) - (one.width + other.width) / 2
            apart_y = abs(one.y - other.y) - (one.height + other.height) / 2
            assert max(apart_x, apart_y) > 0, f"{one} covers {other}"


def test_an_arrow_and_the_one_back_bow_to_different_sides() -> None:
    boxes = state_boxes(["A", "B", "C"], 5.0, 4.0, lambda text: (0.5, 0.15))
    there, back = bend_arrows(boxes, [("A", "B"), ("B", "A")], 5.0, 4.0)
    middle = [
        curve(boxes[a], boxes[b], bend)[20] for a, b, bend in (("A", "B", there), ("B", "A", back))
    ]
    assert np.hypot(*(middle[0] - middle[1])) > 0.1


@pytest.mark.parametrize("height", [1.0, 2.0])
def test_an_arrow_crosses_a_box_where_it_goes_through_it(height: float) -> None:
    box = Box(0.0, 0.0, 1.0, 1.0)
    assert crosses(np.array([[-2.0, 0.2], [2.0, 0.3]]), box)
    assert crosses(np.array([[-2.0, 0.2], [0.1, 0.1]]), box)
    assert not crosses(np.array([[-2.0, 0.2], [-0.6, 0.1]]), box)
    assert not crosses(np.array([[-2.0, 0.6 * height], [2.0, 0.6 * height]]), box)
    assert crosses(np.array([[0.2, -2.0], [0.2, 2.0]]), box)
