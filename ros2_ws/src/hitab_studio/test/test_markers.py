"""Markers of the field: their content, lifetime and subscribers."""

from types import SimpleNamespace
from typing import Any

import numpy as np
from visualization_msgs.msg import Marker

from hitab_ros.timing import DISCOVERY_S, UPDATE_S
from hitab_studio.field.markers import FRAME, Markers
from hitab_studio.field.scene import Appearance, Scene

DOING = {"keeper_1": ("performing", "GoFast")}
COLORS = {"GoFast": 0}


class Publisher:
    """A publisher that keeps the messages, with a given number of subscribers."""

    def __init__(self) -> None:
        self.subscribers = 1
        self.arrays: list[Any] = []

    def get_subscription_count(self) -> int:
        return self.subscribers

    def publish(self, array: Any) -> None:
        self.arrays.append(array)


def markers() -> tuple[Markers, Publisher]:
    publisher = Publisher()
    link: Any = SimpleNamespace(node=SimpleNamespace(create_publisher=lambda *_: publisher))
    return Markers(link), publisher


def scene(seconds: float, mode: str = "running") -> Scene:
    names = ("keeper_1", "ball")
    looks = {name: Appearance(faces=name != "ball") for name in names}
    places = np.zeros((2, 5))
    size = (20.0, 20.0)
    return Scene(size, names, names, (0.3, 0.3), places, looks, mode=mode, seconds=seconds)


def test_each_thing_is_in_its_namespaces_and_lasts_for_a_while():
    shown, publisher = markers()
    shown.look(scene(1.0), DOING, COLORS)
    (array,) = publisher.arrays
    before, *there = array.markers
    assert before.action == Marker.DELETEALL, "what is no longer there goes"
    assert {(marker.ns, marker.id) for marker in there} == {
        *(("field", 0), ("things", 0), ("headings", 0), ("names", 0)),
        ("things", 1),  # the ball faces nowhere
    }
    assert all(marker.header.frame_id == FRAME for marker in there)
    assert all(marker.lifetime.sec == DISCOVERY_S for marker in there)


def test_a_world_is_shown_as_often_as_anybody_can_see_and_a_paused_one_at_each_change():
    shown, publisher = markers()
    publisher.subscribers = 0
    shown.look(scene(1.0), DOING, COLORS)
    shown.show(scene(2.0), DOING, COLORS)
    assert publisher.arrays == [], "no markers without subscribers"
    publisher.subscribers = 1
    shown.look(None, {}, {})
    for i in range(5):
        shown.show(scene(1.0 + i * UPDATE_S / 2), DOING, COLORS)
    assert len(publisher.arrays) == 3
    for _ in range(2):
        shown.show(scene(9.0, "paused"), DOING, COLORS)
    shown.look(scene(9.0, "paused"), DOING, COLORS)  # before it fades
    assert len(publisher.arrays) == 6
