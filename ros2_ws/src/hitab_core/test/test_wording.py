"""Names of agents in the texts that people read."""

import pytest

from hitab_core import in_groups

SUPERIORS = {
    **dict.fromkeys(("a", "b"), "squad_2"),
    **dict.fromkeys(("c", "d"), "squad_10"),
    **dict.fromkeys(("squad_2", "squad_10"), "chief"),
    **dict.fromkeys(("chief", "lone"), ""),
}


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ("", []),
        ("a", ["a"]),
        ("a b", ["squad_2 (2 agents)"]),
        ("a b c d", ["squad_2 (2 agents)", "squad_10 (2 agents)"]),
        ("a b c squad_2", ["c", "squad_2 (2 agents)"]),
        ("a b c d squad_2 squad_10", ["chief (4 agents)"]),
        ("a b c d squad_2 squad_10 chief lone", ["chief (4 agents)", "lone"]),
        ("chief squad_2", ["chief", "squad_2"]),
        ("stranger", ["stranger"]),
    ],
)
def test_complete_groups_are_named_by_their_topmost_commander(names, expected):
    assert in_groups(names.split(), SUPERIORS) == expected


def test_commanders_in_a_circle_do_not_hold_up_whoever_names_them():
    assert len(in_groups(["a", "b"], {"a": "b", "b": "a"})) <= 2
