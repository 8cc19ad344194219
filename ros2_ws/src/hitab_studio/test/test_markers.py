"""The field as markers: what they are, for how long, and who gets them."""

from types import MappingProxyType, SimpleNamespace

import numpy as np
from visualization_msgs.msg import Marker

from hitab_studio.markers import EVERY_SECONDS, FRAME, LIFETIME_SECONDS, Markers
from hitab_studio.scene import Look, Scene

DOING = {"keeper_1": ("performing", "GoFast")}
COLORS = {"GoFast": 0}


class Publisher:
    """Keeps what is published for a number of subscribers."""

    def __init__(self):
        self.subscribers = 1
        self.arrays = []

    def get_subscription_count(self):
        return self.subscribers

    def publish(self, array):
        self.arrays.append(array)


def markers():
    publisher = Publisher()
    node = SimpleNamespace(create_publisher=lambda *arguments: publisher)
    return Markers(SimpleNamespace(node=node)), publisher


def scene(seconds, mode="running", names=("keeper_1", "ball")):
    return Scene(
        world="keepaway",
        cycle=round(seconds * 10),
        episode=1,
        episode_cycle=0,
        mode=mode,
        note="",
        seconds=seconds,
        size=(20.0, 20.0),
        names=names,
        kinds=names,
        radii=(0.3,) * len(names),
        places=np.zeros((len(names), 5)),
        said=MappingProxyType({}),
        looks=MappingProxyType({name: Look(faces=name != "ball") for name in names}),
    )


def test_each_thing_is_in_its_namespaces_and_lasts_for_a_while():
    shown, publisher = markers()
    shown.look(scene(1.0), DOING, COLORS)
    (array,) = publisher.arrays
    places = {(marker.ns, marker.id) for marker in array.markers}
    assert places == {
        *(("field", 0), ("things", 0), ("headings", 0), ("names", 0)),
        ("things", 1),  # the ball faces nowhere
    }
    assert all(marker.header.frame_id == FRAME for marker in array.markers)
    assert all(marker.lifetime.sec == LIFETIME_SECONDS for marker in array.markers)


def test_what_is_no_longer_there_is_deleted():
    shown, publisher = markers()
    shown.look(scene(1.0), DOING, COLORS)
    shown.show(scene(2.0, names=("keeper_1",)), DOING, COLORS)
    gone = {(m.ns, m.id) for m in publisher.arrays[-1].markers if m.action == Marker.DELETE}
    assert gone == {("things", 1), ("headings", 1), ("names", 1)}


def test_a_running_world_is_shown_as_often_as_anybody_can_see():
    shown, publisher = markers()
    shown.look(None, {}, {})
    assert publisher.arrays == []
    for i in range(5):
        shown.show(scene(1.0 + i * EVERY_SECONDS / 2), DOING, COLORS)
    assert len(publisher.arrays) == 3


def test_each_change_of_a_paused_world_is_shown_and_shown_again_before_it_fades():
    shown, publisher = markers()
    shown.look(None, {}, {})
    shown.show(scene(1.0, "paused"), DOING, COLORS)
    shown.show(scene(1.0, "paused"), DOING, COLORS)
    shown.look(scene(1.0, "paused"), DOING, COLORS)
    assert len(publisher.arrays) == 3


def test_nothing_is_made_for_nobody():
    shown, publisher = markers()
    publisher.subscribers = 0
    shown.look(scene(1.0), DOING, COLORS)
    shown.show(scene(2.0), DOING, COLORS)
    assert publisher.arrays == []
    publisher.subscribers = 1
    shown.look(scene(2.0), DOING, COLORS)
    assert len(publisher.arrays) == 1
