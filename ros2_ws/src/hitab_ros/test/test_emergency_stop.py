"""All robots stop at one word, whoever says it, and whoever comes late hears it."""

import time

import pytest
from hitab_msgs.msg import EmergencyStop
from hypothesis import given
from hypothesis import strategies as st
from rclpy.experimental import EventsExecutor

from hitab_ros import EmergencySwitch, names, qos
from hitab_ros.emergency_stop import supersedes
from hitab_ros.spinning import make_node
from hitab_ros.stamps import as_time, nanoseconds
from hitab_ros.testing import context_of_its_own, spin_until


class Room:
    """Nodes that are spun together."""

    def __init__(self, context):
        self.context = context
        self.executor = EventsExecutor(context=context)

    def node(self, name):
        node = make_node(name, context=self.context)
        self.executor.add_node(node)
        return node

    def leave(self, node):
        self.executor.remove_node(node)
        node.destroy_node()

    def until(self, condition):
        spin_until(self.executor, condition)


@pytest.fixture
def room():
    with context_of_its_own() as context:
        room = Room(context)
        yield room
        for node in list(room.executor.get_nodes()):
            room.leave(node)
        room.executor.shutdown()


def test_a_relay_stops_and_keeps_the_stop_for_those_who_come_late(room):
    told = []
    relay = EmergencySwitch(room.node("relay"), told.append, hands_on=True)
    person = room.node("person")
    switch = EmergencySwitch(person)
    switch.set(True, "ann", "a dog")
    room.until(lambda: relay.engaged)
    assert (told[-1].by, told[-1].reason) == ("ann", "a dog")
    assert switch.delivered(10.0)
    room.leave(person)

    late = EmergencySwitch(room.node("late"))
    room.until(lambda: late.engaged)
    late.set(False, "ben")
    room.until(lambda: not relay.engaged)
    assert [message.engaged for message in told] == [True, False]


def test_a_release_counts_though_the_clock_of_its_sender_is_behind(room, monkeypatch):
    relay = EmergencySwitch(room.node("relay"), hands_on=True)
    ahead, behind = EmergencySwitch(room.node("ahead")), EmergencySwitch(room.node("behind"))
    now = time.time_ns()
    monkeypatch.setattr(time, "time_ns", lambda: now + 60 * 10**9)
    ahead.set(True, "ann")
    monkeypatch.setattr(time, "time_ns", lambda: now)
    room.until(lambda: relay.engaged and behind.engaged)
    behind.set(False, "ben")
    room.until(lambda: not relay.engaged and not ahead.engaged)


@pytest.mark.parametrize("ahead_s", [0, 365 * 24 * 3600])
def test_a_message_by_hand_is_meant_now(room, ahead_s):
    relay = EmergencySwitch(room.node("relay"), hands_on=True)
    relay.set(False, "ann")
    by_hand = room.node("by_hand").create_publisher(
        EmergencyStop, names.EMERGENCY_STOP, qos.LATCHED
    )
    stamp = as_time(time.time_ns() + ahead_s * 10**9 if ahead_s else 0)
    by_hand.publish(EmergencyStop(stamp=stamp, engaged=True))
    room.until(lambda: relay.engaged)
    relay.set(False, "ann")
    assert not relay.engaged


def test_a_restarted_relay_goes_on_with_what_it_kept(room):
    kept = EmergencyStop(stamp=as_time(time.time_ns()), engaged=True, by="ann")
    told = []
    relay = EmergencySwitch(room.node("relay"), told.append, hands_on=True)
    relay.take(kept)
    assert relay.engaged
    assert told == [kept]


messages = st.builds(
    lambda stamp, engaged: EmergencyStop(stamp=as_time(stamp), engaged=engaged),
    st.integers(1, 5),
    st.booleans(),
)


@given(st.permutations(range(4)), st.lists(messages, min_size=4, max_size=4))
def test_the_order_in_which_messages_come_makes_no_difference(order, heard):
    def outcome(sequence):
        state = sequence[0]
        for message in sequence[1:]:
            state = message if supersedes(message, state) else state
        return nanoseconds(state.stamp), state.engaged

    assert outcome(heard) == outcome([heard[i] for i in order])
