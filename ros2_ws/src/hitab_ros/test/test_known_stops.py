"""A robot that knows a stop stands still until its release, in any order of messages."""

from dataclasses import dataclass, field

from hypothesis import given, settings
from hypothesis import strategies as st

from hitab_ros import KnownStops
from hitab_ros.stopping.known_stops import KEPT_MAX, must_tell

RELAYS = 3
PEOPLE = 2
"""Participants that do not rebroadcast received stops."""


@dataclass
class Participant:
    hands_on: bool
    known: KnownStops = field(default_factory=KnownStops)
    published: list[KnownStops] = field(default_factory=list)

    def know(self, known, heard, *, tells):
        """Update the known stops, as `EmergencySwitch` does."""
        before, self.known = self.known, known
        if tells and must_tell(before, known, heard):
            self.published.append(known)

    def hear(self, heard):
        self.know(self.known.joined(heard), heard, tells=self.hands_on)


class Room:
    """Participants, any of which may be out of reach of any other, for any time."""

    def __init__(self):
        self.all = [Participant(i < RELAYS) for i in range(RELAYS + PEOPLE)]
        self.stops = 0
        self.buttons = set()  # stops by programs that only publish
        self.may_be_ended = set()

    def press(self, who):
        """A participant stops all."""
        self.stops += 1
        one = self.all[who]
        one.known = one.known.stopped(f"s{self.stops}", "ann")
        one.published.append(one.known)
        assert one.known

    def release(self, who):
        one = self.all[who]
        self.may_be_ended |= {*one.known.stops}
        one.known = one.known.released_by("ben")
        one.published.append(one.known)
        assert not one.known

    def push(self, who):
        """A program that is no participant stops all; at first only one participant hears that."""
        self.stops += 1
        self.buttons.add(f"s{self.stops}")
        self.deliver_button(who, -1)

    def deliver_button(self, who, which):
        """A stop of such a program is delivered to another participant, or again."""
        if self.buttons:
            button = sorted(self.buttons)[which % len(self.buttons)]
            one = self.all[who]
            known = one.known.stopped(button, "button")
            one.know(known, known, tells=one.hands_on)
            assert one.known or button in one.known.released

    def let_go(self, who):
        """A program that is no participant releases the stops that its receiver knows."""
        one = self.all[who]
        self.may_be_ended |= {*one.known.stops}
        known = one.known.released_by("button")
        one.know(known, known, tells=one.hands_on)
        assert not one.known

    def deliver(self, who, which):
        """A message from any time arrives, for the first time or again."""
        said = [known for one in self.all for known in one.published]
        if said:
            heard = said[which % len(said)]
            one = self.all[who]
            one.hear(heard)
            assert bool(one.known) or {*heard.stops} <= {*one.known.released}

    def restart(self, who):
        one = self.all[who]
        one.known = KnownStops.of_texts(**one.known.texts())
        one.published = [one.known] if one.known and one.hands_on else []

    def forget(self, who):
        """A participant ends, and another one starts that knows nothing."""
        self.all[who].known, self.all[who].published = KnownStops(), []

    def settle(self):
        """All participants hear the last message of each, until none has more to publish.

        In time, participants that rebroadcast publish all stops that they know.
        """
        for _ in range(20):
            for one in self.all:
                published = one.published[-1] if one.published else KnownStops()
                if one.hands_on and one.known.stops.keys() - published.stops.keys():
                    one.published.append(one.known)
            said = [(one, one.published[-1]) for one in self.all if one.published]
            for speaker, last in said:
                for one in self.all:
                    if one is not speaker:
                        one.hear(last)
            if said == [(one, one.published[-1]) for one in self.all if one.published]:
                return
        raise AssertionError("they go on and on")

    def check(self):
        for one in self.all:
            assert not one.known.stops.keys() & one.known.released.keys()
            assert {*one.known.released} <= self.may_be_ended


who = st.integers(0, RELAYS + PEOPLE - 1)
which = st.integers(0, 50)
STEPS = st.lists(
    st.one_of(
        *(
            st.tuples(st.just(name), who)
            for name in ("press", "release", "push", "let_go", "restart", "forget")
        ),
        *(st.tuples(st.just(name), who, which) for name in ("deliver", "deliver_button")),
    ),
    max_size=30,
)


@settings(max_examples=500, deadline=None)
@given(STEPS, who)
def test_all_agree_and_are_released_by_who_knows_all_and_by_nobody_else(steps, last):
    room = Room()
    for step, *arguments in steps:
        getattr(room, step)(*arguments)
        room.check()
    relays = room.all[:RELAYS]
    heard = [
        *(one.known for one in relays),
        *(one.published[-1] for one in room.all if one.published),
    ]
    held = {stop for known in heard for stop in known.stops}
    held -= {stop for known in heard for stop in known.released}
    room.settle()
    room.check()
    assert [bool(one.known) for one in relays] == [bool(held)] * RELAYS
    room.release(last)
    room.settle()
    assert not any(one.known for one in relays)


stops = st.builds(
    lambda stops, released: KnownStops(
        {s: "ann" for s in stops if s not in released}, dict.fromkeys(released, "ben")
    ),
    st.frozensets(st.sampled_from("abcdef")),
    st.frozensets(st.sampled_from("abcdef")),
)


@given(
    st.lists(stops, min_size=1, max_size=5).flatmap(
        lambda s: st.tuples(st.just(s), st.permutations(s))
    )
)
def test_the_order_in_which_messages_come_and_how_often_makes_no_difference(heard):
    def outcome(messages):
        known = KnownStops()
        for message in messages:
            known = known.joined(message)
        return known

    first, second = heard
    assert outcome(first) == outcome(second) == outcome([*first, *second])


def test_what_is_known_stays_small_and_a_button_that_is_held_down_goes_on_stopping():
    known = KnownStops()
    for i in range(3 * KEPT_MAX):
        known = known.stopped(f"1.{i}", "button")
        assert known
        if i % 7 == 0:
            known = known.released_by("ben")
            assert not known
            assert not known.stopped(f"1.{i}", "button"), "delivered again"
    assert len(known.stops) <= KEPT_MAX
    assert len(known.released) == KEPT_MAX


def test_people_read_who_has_stopped_the_robots_and_why():
    known = (
        KnownStops().stopped("1", "ann", "a dog").stopped("2", "", "").stopped("3", "ann", "a dog")
    )
    assert known.who == "ann (a dog), somebody"
    assert KnownStops.of_texts(**known.texts()) == known
    assert not KnownStops().who
