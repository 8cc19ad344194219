"""Whatever a joystick sends, nothing moves or is commanded unless its switch is held."""

import math
from dataclasses import dataclass
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hitab_gamepad.joystick_mapping import read_mapping
from hitab_gamepad.stick import Stick, StickActions
from hitab_ros.timing import AT_ONCE_S

MAPPING = read_mapping("xbox")
A, LB, RB = 0, 4, 5
AHEAD, UP = 1, 7
STILL = (0.0, 0.0, 0.0)
WALL = 1e9


@dataclass
class Player:
    """A person with a joystick; time passes between messages."""

    stick: Stick
    now: float = 0.0

    def send(
        self, *down: int, ahead: float = 0.0, after: float = 0.1, age: float = 0.0
    ) -> StickActions:
        self.now += after
        axes = [0.0] * 8
        axes[AHEAD] = ahead
        buttons = [int(number in down) for number in range(11)]
        return self.take(axes, buttons, age)

    def take(self, axes: list[float], buttons: list[int], age: float = 0.0) -> StickActions:
        wall = WALL + self.now
        return self.stick.take(axes, buttons, wall - age, wall, self.now)


@pytest.fixture
def player() -> Player:
    player = Player(Stick(MAPPING))
    player.send()
    return player


numbers = st.floats() | st.sampled_from([math.nan, math.inf, -math.inf, 0.0, 1.0, -1.0])
messages = st.tuples(
    st.floats(0.0, 1.0),
    st.lists(numbers, min_size=6, max_size=9),
    st.lists(st.integers(-2, 2), min_size=9, max_size=12),
    st.floats(-1.0, 1.0),
)


@given(st.lists(messages, max_size=12))
def test_whatever_is_sent_what_counts_is_finite_held_and_fresh(sent):
    player = Player(Stick(MAPPING))
    released = False
    heard = -math.inf
    for pause, axes, buttons, age in sent:
        player.now += pause
        taken = player.take(axes, buttons, age)
        sound = (
            len(axes) >= 8
            and len(buttons) >= 11
            and all(map(math.isfinite, axes[:8]))
            and age <= MAPPING.timeout
        )
        if not sound:
            assert taken.trouble
        if player.now > heard + MAPPING.timeout:
            released = False
        if taken.trouble:
            assert taken.velocity == STILL
            assert {*taken.pressed} <= {"RB"}
            continue
        heard = player.now
        held = buttons[LB] != 0
        if not (held and released):
            assert taken.velocity == STILL
            assert {*taken.pressed} <= {"RB"}
        released = released or not held
        for way, speed in enumerate(taken.velocity):
            axis = MAPPING.driving.get(("ahead", "left", "turn")[way])
            assert abs(speed) <= (abs(axis.speed) if axis else 0.0)


def test_only_the_moment_counts_in_which_a_button_goes_down(player):
    player.send(LB)
    assert player.send(LB, A).pressed == ("A",)
    assert player.send(LB, A).pressed == ()
    assert player.send(LB).pressed == ()
    assert player.send(LB, A).pressed == ("A",)


@given(st.lists(st.tuples(st.booleans(), st.floats(0.0, 2 * AT_ONCE_S)), max_size=60))
def test_a_contact_that_flaps_presses_its_button_no_faster_than_a_person(flaps):
    player = Player(Stick(MAPPING))
    player.send()
    player.send(LB)
    pressed = []
    for down, after in flaps:
        if player.send(LB, *([A] if down else []), after=after).pressed:
            pressed.append(player.now)
    assert all(later - earlier >= AT_ONCE_S - 1e-9 for earlier, later in pairwise(pressed))


def test_without_the_switch_nothing_counts_but_the_emergency_stop(player):
    assert player.send(A, ahead=1.0) == StickActions()
    assert player.send(RB).pressed == ("RB",)
    player.send(LB)
    assert player.send(LB, ahead=1.0).velocity[0] == MAPPING.driving["ahead"].speed
    assert player.send(ahead=1.0).velocity == STILL


def test_what_is_down_when_messages_begin_or_come_again_has_not_been_pressed():
    player = Player(Stick(MAPPING))
    assert player.send(LB, A, ahead=1.0) == StickActions()
    assert player.send(LB, ahead=1.0) == StickActions()
    player.send()
    assert player.send(LB, ahead=1.0).velocity != STILL
    assert player.stick.is_lost(player.now + MAPPING.timeout + 0.01)
    assert player.send(LB, A, ahead=1.0, after=MAPPING.timeout + 0.1) == StickActions()


def test_the_emergency_stop_counts_in_any_message(player):
    assert player.send(RB, age=9.0).pressed == ("RB",), "old"
    player.send()
    assert player.take([], [0] * 5 + [1]).pressed == ("RB",), "too short"
    assert Player(Stick(MAPPING)).send(RB).pressed == ("RB",), "the first one"


def test_messages_out_of_order_do_not_count_and_stamps_ahead_of_the_clock_do(player):
    player.send(LB)
    player.send(LB, ahead=1.0)
    assert "out of order" in player.send(LB, ahead=-1.0, after=0.01, age=0.3).trouble
    assert player.send(LB, ahead=1.0, age=-5.0).velocity[0] > 0.0


def test_a_half_of_an_axis_is_a_button(player):
    player.send(LB)
    player.now += 0.1
    axes = [0.0] * 8
    axes[UP] = 1.0
    assert player.take(axes, [int(n == LB) for n in range(11)]).pressed == ("Up",)


def test_a_stick_drives_slowly_beside_its_dead_zone(player):
    player.send(LB)
    assert player.send(LB, ahead=0.1).velocity == STILL
    assert 0.0 < player.send(LB, ahead=0.11).velocity[0] < 0.01
    assert player.send(LB, ahead=-9.0).velocity[0] == -MAPPING.driving["ahead"].speed
