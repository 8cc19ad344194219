"""People learn keys by heart: a key never comes to mean another behavior."""

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
    assert in_order(["Turn", "Chase", "Go(A)"], {"Chase"}) == ["Go(A)", "Turn", "Chase"]
