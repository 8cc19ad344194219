"""The files that say what the buttons of a joystick do."""

from pathlib import Path

import pytest

from hitab_client import DescriptionError
from hitab_client.demonstrating.pressed import KEY_ACTIONS
from hitab_gamepad.joystick_mapping import (
    Button,
    parse_mapping,
    read_mapping,
    shipped_mappings,
)

RIGHT = """
buttons: {A: 0, B: 1, C: 2, Up: {axis: 3, above: 0.5}}
hold: B
behaviors: {A: GoTo(ball), Up: 2}
actions: {C: stop}
driving: {ahead: {axis: 1, speed: -0.3}}
"""


def parsed(text):
    return parse_mapping(text, Path("my.yaml"))


def test_a_mapping_names_buttons_and_what_they_do():
    mapping = parsed(RIGHT)
    assert mapping.buttons["Up"] == Button(axis=3, above=0.5)
    assert mapping.behaviors == {"A": "GoTo(ball)", "Up": 2}
    assert (mapping.buttons_min, mapping.axes_min) == (3, 4)
    assert mapping.driving["ahead"].speed == -0.3


@pytest.mark.parametrize("name", shipped_mappings())
def test_shipped_mappings_give_a_button_to_all_that_a_person_needs(name):
    mapping = read_mapping(name)
    needed = {*KEY_ACTIONS} - {"redo"}
    assert needed <= {*mapping.actions.values()}
    assert {*mapping.behaviors.values()} == {1, 2, 3, 4}
    assert {*mapping.driving} == {"ahead", "turn"}


def test_what_is_wrong_is_named_with_its_line():
    for old, new, wrong in [
        ("hold: B", "hold: D", r"my.yaml:3: `D` is not among the buttons \(known: A, B, C, Up\)"),
        ("hold: B", "hold: A", "my.yaml:4: `A` is used twice: for hold and for a behavior"),
        ("C: 2", "C: 0", "my.yaml:2: `C:` is the same button as A"),
        ("C: stop", "", "no button stops the robots: give one the action `stop`"),
        ("GoTo(ball)", "GoTo(", "my.yaml:4: `A:` must be a behavior, such as Forward"),
        ("Up: 2", "Up: 0", "`Up:` must be a behavior, .* or the number of one, from 1, not 0"),
        (", above: 0.5", "", "needs either `above:` or `below:`"),
        ("-0.3", "0", "my.yaml:6: `speed:` must be a number other than 0, not 0"),
        ("driving:", "numbers: {power: {ahead: 1}}\ndriving:", "`power:` needs either `axis:`"),
        ("driving:", "timeout: .nan\ndriving:", "`timeout:` must be at most 2, not nan"),
    ]:
        assert old in RIGHT
        with pytest.raises(DescriptionError, match=wrong):
            parsed(RIGHT.replace(old, new, 1))


def test_a_mapping_that_is_not_there_names_those_that_are():
    with pytest.raises(DescriptionError, match=r"none is shipped \(known: gamepad, xbox"):
        read_mapping("xbx")
