"""Scenes are read from the bytes of states; what has not changed is not converted again."""

from typing import Any

import numpy as np
import pytest
from hitab_msgs.msg import Entity, Look, WorldState
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message

from hitab_core import CYCLE_MAX
from hitab_ros.messages.checks import BadMessage
from hitab_studio.field.scene import scene_of
from hitab_studio.field.scene_reader import SceneReader

TEXT = st.text(st.characters(categories=["L", "N"]), max_size=9)
NUMBER = st.floats(allow_nan=True)


def state(*names: str, say: str = "", note: str = "", **numbers: Any) -> Any:
    things = [Entity(name=name, kind="ant", radius=0.2, say=say) for name in names]
    looks = [Look(kind="ant", color="#123456", opacity=0.5)]
    made = WorldState(width=20.0, height=10.0, entities=things, looks=looks, note=note)
    made.header.frame_id = say
    return changed(made, **numbers)


def changed(made: Any, x: float = 0.0, sec: int = 0, **numbers: int) -> Any:
    for thing in made.entities:
        thing.x, thing.vy = x, -x
    made.header.stamp.sec = sec
    for name, number in numbers.items():
        setattr(made, name, number)
    return made


def read(reader: SceneReader, message: Any) -> Any:
    """Return what a reader makes of a message, which must be the same as the message says."""
    got, wanted = reader(serialize_message(message)), scene_of(message)
    assert (got.header, got.cycle, got.change) == (message.header, message.cycle, message.change)
    np.testing.assert_array_equal(got.scene.places, wanted.places)
    fields = vars(wanted).keys() - {"places"}
    assert {name: getattr(got.scene, name) for name in fields} == {
        name: getattr(wanted, name) for name in fields
    }
    return got.scene


@given(st.lists(TEXT, max_size=5), TEXT, TEXT, NUMBER, st.integers(-9, 9))
def test_only_numbers_are_read_again(names, say, note, x, sec):
    reader = SceneReader()
    first = read(reader, state(*names, say=say, note=note, change=7))
    more = {"cycle": 5, "episode": 2, "episode_cycle": 3, "change": 9}
    second = read(reader, state(*names, say=say, note=note, x=x, sec=sec, **more))
    assert second.names is first.names
    assert second.looks is first.looks


@pytest.mark.parametrize(
    "other",
    [
        state("ant_1", "ant_3"),
        state("ant_1"),
        state("ant_1", "ant_2", say="hey"),
        state("ant_1", "ant_2", note="out"),
        state("ant_1", "ant_2", mode="paused"),
        state("ant_1", "ant_2", width=30.0),
    ],
)
def test_another_state_is_read_as_a_whole(other):
    reader = SceneReader()
    read(reader, state("ant_1", "ant_2"))
    read(reader, other)
    read(reader, state("ant_1", "ant_2", cycle=3))


@pytest.mark.parametrize("wrong", [{"cycle": CYCLE_MAX + 1}, {"width": float("inf")}])
def test_a_wrong_number_is_refused_also_if_only_numbers_have_changed(wrong):
    reader = SceneReader()
    read(reader, state("ant_1"))
    with pytest.raises(BadMessage):
        reader(serialize_message(state("ant_1", **wrong)))
    read(reader, state("ant_1", cycle=3))


def test_a_state_of_another_swarm_is_told_apart_though_nothing_else_differs():
    reader, made = SceneReader(), state("ant")
    for swarm in ("pond-00000001", "pond-00000001", "pond-00000002"):
        made.swarm = swarm
        assert reader(serialize_message(made)).swarm == swarm
