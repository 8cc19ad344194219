"""The page about keys and gamepads lists what there is."""

import re
from pathlib import Path

from hitab_bringup.driving_view import SPACE
from hitab_client.demonstrating import ACTIONS, keyboard, read_mapping
from hitab_client.demonstrating.joystick_mapping import parse_mapping, shipped_mappings

PAGE = (Path(__file__).parents[1] / "docs/driving.md").read_text(encoding="utf-8")
TABLE = [
    [cell.strip() for cell in line.strip()[1:-1].split("|")]
    for line in PAGE.split("| key | button |")[1].split("\n\n")[0].splitlines()[2:]
]


def rows_of(button: str) -> list[list[str]]:
    return [row for row in TABLE if re.search(rf"\b{button}\b", row[1])]


def test_each_key_is_in_the_table():
    keys = "".join(row[0] for row in TABLE)
    for key in keyboard.ACTION_KEYS:
        assert f"`{SPACE if key == ' ' else key}`" in keys


def test_each_button_does_what_the_table_says():
    key_of = {action: key for key, action in keyboard.ACTION_KEYS.items()}
    for name in shipped_mappings():
        mapping = read_mapping(name)
        for button, action in mapping.actions.items():
            key = SPACE if key_of[action] == " " else key_of[action]
            assert any(f"`{key}`" in row[0] for row in rows_of(button)), (name, button)
        assert all(rows_of(button) for button in (*mapping.behaviors, mapping.hold))


def test_actions_and_the_mapping_of_the_page_are_right():
    assert all(f"`{action}`" in PAGE for action in ACTIONS)
    example = re.search(r"\n((?:    .*\n)+)\n- A number stands", PAGE)
    assert example is not None
    mapping = parse_mapping(re.sub("(?m)^    ", "", example[1]), Path("page.yaml"))
    assert mapping.hold == "LB"
