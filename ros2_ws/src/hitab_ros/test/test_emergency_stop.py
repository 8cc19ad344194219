"""All robots stop on one message from any node, and nodes that join late receive the stop."""

import time

import pytest
from hitab_msgs.msg import EmergencyStop
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.experimental import EventsExecutor

from hitab_ros import EmergencySwitch, KnownStops, names, qos
from hitab_ros.messages.stamps import as_time
from hitab_ros.nodes.spinning import make_node
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

    def button(self, *relays, profile=qos.EVENTS, events=None):
        """Return a publisher of a node that is no participant, connected to these relays."""
        publisher = self.node("button").create_publisher(
            EmergencyStop, names.EMERGENCY_STOP, profile, event_callbacks=events
        )
        self.until(lambda: publisher.get_subscription_count() >= len(relays))
        return publisher


@pytest.fixture
def room():
    with context_of_its_own() as context:
        room = Room(context)
        yield room
        for node in list(room.executor.get_nodes()):
            room.leave(node)
        room.executor.shutdown()


def test_a_relay_stops_and_keeps_the_stop_for_those_who_come_late(room):
    changes = []
    relay = EmergencySwitch(room.node("relay"), changes.append, hands_on=True)
    person = room.node("person")
    switch = EmergencySwitch(person)
    switch.set(True, "ann", "a dog")
    room.until(lambda: relay.engaged)
    assert changes[-1].who == "ann (a dog)"
    assert switch.delivered(10.0)
    room.leave(person)

    late = EmergencySwitch(room.node("late"))
    room.until(lambda: late.engaged)
    late.set(False, "ben")
    room.until(lambda: not relay.engaged)
    assert [bool(known) for known in changes] == [True, False]


@pytest.mark.parametrize("ahead_s", [None, -35.0, -3600.0, 0.0, 50.0, 365 * 24 * 3600.0])
def test_each_press_of_a_button_stops_whatever_its_clock_says(room, ahead_s):
    relay = EmergencySwitch(room.node("relay"), hands_on=True)
    far = EmergencySwitch(room.node("far"), hands_on=True)
    button = room.button(relay, far)
    stamp = as_time(0 if ahead_s is None else time.time_ns() + int(ahead_s * 1e9))
    press = EmergencyStop(stamp=stamp, engaged=True, by="button")
    for _ in range(3):
        button.publish(press)
        room.until(lambda: relay.engaged and far.engaged)
        button.publish(EmergencyStop(stamp=stamp, engaged=False))
        room.until(lambda: not (relay.engaged or far.engaged))
    button.publish(press)
    room.until(lambda: relay.engaged and far.engaged)
    far.set(False, "ben")
    room.until(lambda: not relay.engaged)


def test_a_stop_that_was_latched_is_heard_late_and_once(room):
    latched = room.button(profile=qos.LATCHED)
    latched.publish(EmergencyStop(engaged=True, by="button"))
    relay = EmergencySwitch(room.node("relay"), hands_on=True)
    room.until(lambda: relay.engaged)
    relay.set(False, "ben")
    again = []
    late = EmergencySwitch(room.node("late"), again.append, hands_on=True, known=relay.known)
    room.until(lambda: latched.get_subscription_count() == 4)
    latched.publish(EmergencyStop(engaged=True, by="button"))
    room.until(lambda: late.engaged and relay.engaged)
    assert [len(known.stops) for known in again] == [1], "the earlier one was delivered as well"


def test_a_release_that_was_latched_does_not_end_a_later_stop(room):
    latched = room.button(profile=qos.LATCHED)
    latched.publish(EmergencyStop(engaged=False, by="button"))
    known = KnownStops().stopped("1", "ann")
    relay = EmergencySwitch(room.node("relay"), hands_on=True, known=known)
    room.until(lambda: latched.get_subscription_count() == 2)
    latched.publish(EmergencyStop(engaged=True, by="button"))
    room.until(lambda: len(relay.known.stops) == 2)


def test_a_release_does_not_end_a_stop_that_its_sender_does_not_know(room):
    relay = EmergencySwitch(room.node("relay"), hands_on=True)
    ann, ben = EmergencySwitch(room.node("ann")), EmergencySwitch(room.node("ben"))
    ann.set(True, "ann")
    room.until(lambda: relay.engaged and ben.engaged)
    ann.set(True, "ann")
    ben.set(False, "ben")
    room.until(lambda: relay.known.released)
    assert relay.engaged
    room.until(lambda: ben.engaged)
    ben.set(False, "ben")
    room.until(lambda: not (relay.engaged or ann.engaged))


def test_a_button_that_latches_nothing_is_not_warned_of_those_who_ask_for_it(room):
    relays = [EmergencySwitch(room.node(f"relay_{i}"), hands_on=True) for i in range(2)]
    warned = []
    events = PublisherEventCallbacks(incompatible_qos=warned.append)
    button = room.button(*relays, events=events)
    button.publish(EmergencyStop(engaged=True))
    room.until(lambda: all(relay.engaged for relay in relays))
    assert not warned


@pytest.mark.parametrize("text", ["two\nlines", "x" * 2000, ""])
def test_a_stop_counts_whatever_is_wrong_with_its_text(room, text):
    relay = EmergencySwitch(room.node("relay"), hands_on=True)
    late = EmergencySwitch(room.node("late"))
    room.button(relay, late).publish(EmergencyStop(engaged=True, by=text, reason=text))
    room.until(lambda: relay.engaged)
    later = EmergencySwitch(room.node("later"))
    room.until(lambda: later.engaged)


def test_a_restarted_relay_goes_on_with_what_it_knew(room):
    known = KnownStops().stopped("1", "ann")
    relay = EmergencySwitch(room.node("relay"), hands_on=True, known=known)
    assert relay.engaged
    late = EmergencySwitch(room.node("late"))
    room.until(lambda: late.engaged)
