from __future__ import annotations

import re
from pathlib import Path

import pytest

from hitab_core.automaton import Automaton
from hitab_core.drawing.picture import draw_automata
from hitab_core.drawing.text import automaton_as_text
from hitab_core.texts.errors import HitabError


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


def test_a_picture_that_cannot_be_drawn_is_named(tmp_path: Path, keepaway: Automaton) -> None:
    with pytest.raises(HitabError, match="there is no automaton to draw"):
        draw_automata([], tmp_path / "none.png")
    with pytest.raises(HitabError, match="cannot be drawn"):
        draw_automata([keepaway], tmp_path / "picture.doc")
    with pytest.raises(HitabError, match="cannot be drawn"):
        draw_automata([keepaway], tmp_path / "missing" / "picture.png")
