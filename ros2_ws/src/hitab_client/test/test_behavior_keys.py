"""A key never changes to another behavior, since people learn keys by heart."""

from types import SimpleNamespace
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from hitab_client.demonstrating.behavior_keys import KEYS, Keys, in_order
from hitab_core import FLAGS

names = st.lists(st.text("ABC", min_size=1), unique=True)


@given(st.lists(names, min_size=1))
def test_a_behavior_keeps_its_key_and_no_two_share_one(appearances):
    keys, seen = Keys(), dict[str, str]()
    for behaviors in appearances:
        keys.give("soccer", behaviors)
        now = {name: keys.of("soccer", name) for name in (*behaviors, *FLAGS)}
        assert all(seen[name] == key for name, key in now.items() if seen.get(name))
        seen |= now
    given_keys = [key for key in seen.values() if key]
    assert len(given_keys) == len(set(given_keys))


def test_when_there_are_no_keys_left_a_behavior_has_none():
    keys = Keys()
    keys.give("soccer", [f"Behavior{i}" for i in range(len(KEYS) + 1)])
    assert keys.of("soccer", f"Behavior{len(KEYS)}") == ""
    assert keys.of("soccer", "Done")
    assert keys.of("foraging", "Behavior0") == "", "another domain has its own"


def test_what_was_trained_gets_its_keys_after_what_the_robot_can_do_by_itself():
    assert in_order(["Turn", "Chase", "Go(A)"], {"Chase"}) == ["Turn", "Go(A)", "Chase"]


ROBOT = ["Forward", "TurnLeft"]


def test_a_key_stays_with_its_behavior_in_a_process_that_starts_later(tmp_path):
    studio = Keys(tmp_path / "keys.yaml")
    studio.commandable("robot", [*ROBOT, "Wander"], {"Wander"})
    later = [*ROBOT, "GoTo(A)", "Wander"]
    terminal = Keys(tmp_path / "keys.yaml")
    for keys in (terminal, studio):
        shown = keys.commandable("robot", later, {"GoTo", "Wander"})
        assert shown == [*ROBOT, "Wander", "GoTo(A)"]
    for behavior in later:
        assert studio.of("robot", behavior) == terminal.of("robot", behavior)


def test_keys_that_two_processes_give_at_once_agree(tmp_path):
    one, two = (Keys(tmp_path / "keys.yaml") for _ in range(2))
    one.give("robot", ROBOT)
    two.give("robot", ["TurnLeft", "Dance"])
    assert [two.of("robot", b) for b in ("TurnLeft", "Dance")] == ["2", "3"]


def test_if_no_key_is_left_one_that_is_only_kept_is_given_again(tmp_path):
    earlier, now = (Keys(tmp_path / "keys.yaml") for _ in range(2))
    earlier.give("robot", [f"Old{i}" for i in range(len(KEYS))])
    now.give("robot", ["Old0", "New"])
    assert now.of("robot", "Old0") == KEYS[0]
    assert now.of("robot", "New") == KEYS[1]
    assert earlier.of("robot", "Old1") == KEYS[1], "until it ends"


def test_a_file_of_keys_that_cannot_be_used_keeps_nobody_from_commanding(tmp_path):
    path = tmp_path / "keys.yaml"
    for content in ("[", "robot: 3", "robot: {Forward: 12, TurnLeft: x}"):
        path.write_text(content)
        keys = Keys(path)
        keys.give("robot", ROBOT)
        assert [keys.of("robot", b) for b in ROBOT] == ["1", "2"]
    (tmp_path / "file").write_text("")
    nowhere = Keys(tmp_path / "file" / "keys.yaml")
    nowhere.give("robot", ROBOT)
    assert nowhere.of("robot", "Forward") == "1"


def test_in_training_its_own_name_is_no_command_and_chosen_behaviors_are_all():
    keys = Keys()
    all_of_them = [*ROBOT, "GoTo(A)", "Patrol"]
    began: Any = SimpleNamespace(name="Patrol", possible_states=["GoTo(goal)"], chosen_states=())
    shown = keys.commandable("robot", all_of_them, {"GoTo", "Patrol"}, began)
    assert shown == [*ROBOT, "GoTo(A)", "GoTo(goal)", *FLAGS]
    began = SimpleNamespace(name="Patrol", possible_states=[], chosen_states=["TurnLeft", "Done"])
    chosen = keys.commandable("robot", all_of_them, {"GoTo", "Patrol"}, began)
    assert chosen == ["TurnLeft", *FLAGS]
