"""Percepts and actions as bytes are those of `rclpy`, and read as `rclpy` reads them."""

import contextlib
from array import array
from typing import Any

import pytest
from builtin_interfaces.msg import Time
from hitab_msgs import msg
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message

from hitab_ros.messages.checks import BadMessage
from hitab_ros.messages.cycle_codec import (
    NATIVE,
    action_bytes,
    percept_bytes,
    read_action,
    read_percept,
)

numbers = st.integers(0, 2**64 - 1)
texts = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=12)
floats = st.lists(st.floats(), max_size=6).map(lambda values: array("d", values))
percepts = st.fixed_dictionaries(
    {
        "stamp": st.builds(
            lambda sec, nanosec: Time(sec=sec, nanosec=nanosec),
            st.integers(0, 2**31 - 1),
            st.integers(0, 999_999_999),
        ),
        **dict.fromkeys(("sequence", "cycle", "episode", "seed"), numbers),
        **dict.fromkeys(("look", "lockstep", "restart", "back"), st.booleans()),
        "values": floats,
        "heard": st.lists(texts, max_size=4),
    }
)
actions = st.fixed_dictionaries(
    {
        "agent": texts,
        "sequence": numbers,
        "values": floats,
        "say": texts,
        "taught": st.booleans(),
        "hold": texts,
    }
)


def assert_exchangeable(data: bytes, message: Any, read: Any) -> None:
    """Check that both ways of writing a message and both of reading it agree."""
    written = serialize_message(message)  # may differ in the bytes between and after its fields
    for one in (read(data), read(written), deserialize_message(data, type(message))):
        for field in message.get_fields_and_field_types():
            got, wanted = getattr(one, field), getattr(message, field)
            if field == "values":
                got, wanted = got.tobytes(), wanted.tobytes()  # NaN is equal to nothing
            assert got == wanted, field


@given(percepts)
def test_a_percept_is_written_and_read_as_rclpy_does(fields):
    assert_exchangeable(percept_bytes(**fields), msg.Percept(**fields), read_percept)


@given(actions)
def test_an_action_is_written_and_read_as_rclpy_does(fields):
    assert_exchangeable(action_bytes(**fields), msg.Action(**fields), read_action)


@given(percepts, actions, st.data())
def test_bytes_that_are_cut_off_are_refused(percept, action, draw):
    for data, read in (
        (percept_bytes(**percept), read_percept),
        (action_bytes(**action), read_action),
    ):
        cut = draw.draw(st.integers(4, len(data) - 1))
        with pytest.raises(BadMessage, match="it is no"):
            read(data[:cut])


@given(st.binary(max_size=120))
def test_no_bytes_make_a_reader_fail_otherwise(data):
    for read in (read_percept, read_action):
        with contextlib.suppress(BadMessage):
            read(NATIVE + data)
