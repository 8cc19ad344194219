"""What reaches a base is within limits, finite, and zero when the robot has to stop."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hitab_robots import Drive
from hitab_robots.relay.velocity import NO_VELOCITY, REST_S, SILENT_S, STEP_MAX_S, Gate

DRIVE = Drive((0.5, 0.2, 1.0), (1.0, 1.0, 2.0), (2.0, 2.0, 4.0))
TIMEOUT = 0.3
PERIOD = 0.05


def driven(gate, now, velocity, seconds):
    """Command a velocity for a while; return the time after it and what was sent."""
    sent = []
    for _ in range(round(seconds / PERIOD)):
        now += PERIOD
        gate.command(velocity, now)
        sent.append(gate.velocity(now))
    return now, sent


numbers = st.floats() | st.sampled_from([math.nan, math.inf, -math.inf, 0.0])
events = st.lists(
    st.tuples(
        st.floats(0.0, 1.0),
        st.none() | st.booleans() | st.lists(numbers, min_size=2, max_size=4),
        st.booleans(),
    ),
    max_size=60,
)


@given(events)
def test_whatever_is_commanded_what_is_sent_is_finite_and_within_limits(events):
    gate = Gate(DRIVE, TIMEOUT, 0.0)
    now, commanded, before = 0.0, -math.inf, NO_VELOCITY
    for pause, event, by_hand in events:
        now += pause
        if isinstance(event, bool):
            gate.held = gate.insists = event
        elif event is not None:
            gate.command(event, now, by_hand=by_hand)
            commanded = now
        sent = gate.velocity(now)
        if gate.held:
            assert sent == NO_VELOCITY
        if now - commanded > TIMEOUT:
            assert sent in (NO_VELOCITY, None)
        if sent is None:
            before = NO_VELOCITY
            continue
        for value, last, most, gain, loss in zip(
            sent, before, DRIVE.max_velocity, DRIVE.max_accel, DRIVE.max_decel, strict=True
        ):
            assert math.isfinite(value)
            assert abs(value) <= most
            # It may stop at once, but gains speed within limits.
            step = max(gain, loss) * min(pause, STEP_MAX_S) + 1e-9
            assert value == 0.0 or abs(value - last) <= step
        before = sent


def test_speed_is_gained_and_lost_gradually():
    gate = Gate(DRIVE, TIMEOUT, 0.0)
    now, sent = driven(gate, 0.0, (1.0, 0.0, 0.0), 1.0)
    ahead = [velocity[0] for velocity in sent]
    assert ahead[:3] == pytest.approx([0.05, 0.1, 0.15])
    assert ahead[-1] == 0.5
    _, sent = driven(gate, now, (-1.0, 0.0, 0.0), 1.0)
    ahead = [velocity[0] for velocity in sent]
    assert ahead[:2] == pytest.approx([0.4, 0.3])
    assert 0.0 in ahead  # it stands still before it turns round
    assert ahead[-1] == -0.5


def test_silence_stops_the_robot_at_once_and_then_leaves_it_to_others():
    gate = Gate(DRIVE, TIMEOUT, 0.0)
    now, _ = driven(gate, 0.0, (0.5, 0.0, 0.0), 1.0)
    assert gate.velocity(now + TIMEOUT - 0.01)[0] > 0.0
    assert gate.velocity(now + TIMEOUT + 0.01) == NO_VELOCITY
    assert gate.velocity(now + TIMEOUT + REST_S) == NO_VELOCITY
    assert gate.velocity(now + TIMEOUT + 0.02 + REST_S) is None
    # It starts again from standing still.
    gate.command((0.5, 0.0, 0.0), now + 10.0)
    assert gate.velocity(now + 10.0)[0] <= DRIVE.max_accel[0] * STEP_MAX_S


def test_an_emergency_holds_the_robot_as_long_as_it_lasts():
    gate = Gate(DRIVE, TIMEOUT, 0.0)
    now, _ = driven(gate, 0.0, (0.5, 0.0, 0.0), 1.0)
    gate.held = gate.insists = True
    now, sent = driven(gate, now, (0.5, 0.0, 0.0), 5.0)
    assert {*sent} == {NO_VELOCITY}
    assert gate.velocity(now + 100.0) == NO_VELOCITY
    gate.held = gate.insists = False
    _, sent = driven(gate, now + 100.0, (0.5, 0.0, 0.0), 0.5)
    assert sent[-1][0] > 0.0


def test_a_person_who_drives_by_hand_counts_until_they_are_silent():
    gate = Gate(DRIVE, TIMEOUT, 0.0)
    now, _ = driven(gate, 0.0, (0.5, 0.0, 0.0), 1.0)
    for _ in range(20):
        now += PERIOD
        gate.command((0.0, 0.0, 1.0), now, by_hand=True)
        gate.command((0.5, 0.0, 0.0), now)
        last = gate.velocity(now)
    assert last == (0.0, 0.0, 1.0)
    assert gate.command((math.nan, 0.0, 0.0), now), "the agent's nonsense"
    assert gate.velocity(now) == (0.0, 0.0, 1.0), "does not disturb the person"
    assert gate.command((math.nan, 0.0, 0.0), now, by_hand=True)
    assert gate.velocity(now) == NO_VELOCITY
    now, sent = driven(gate, now, (0.5, 0.0, 0.0), TIMEOUT)
    assert {*sent[:-1]} == {NO_VELOCITY}
    _, sent = driven(gate, now, (0.5, 0.0, 0.0), 1.0)
    assert sent[-1] == (0.5, 0.0, 0.0)


def test_a_person_who_drives_by_hand_and_falls_silent_stops_the_robot():
    gate = Gate(DRIVE, TIMEOUT, 0.0)
    gate.command((0.5, 0.0, 0.0), 0.0, by_hand=True)
    assert gate.velocity(TIMEOUT)[0] > 0.0
    assert gate.velocity(TIMEOUT + 0.01) == NO_VELOCITY
    gate.command((0.5, 0.0, 0.0), 1.0, by_hand=True)
    gate.held = gate.insists = True
    assert gate.velocity(1.0) == NO_VELOCITY
    gate.held = gate.insists = False
    assert gate.velocity(1.1) == NO_VELOCITY, "it is commanded anew after an emergency"


def test_an_agent_that_falls_silent_while_it_moves_must_not_drive_again_unasked():
    gate = Gate(DRIVE, TIMEOUT, 0.0)
    now = 0.0
    for velocity, pause, by_hand, may in (
        ((0.5, 0.0, 0.0), SILENT_S, False, True),
        ((0.5, 0.0, 0.0), SILENT_S + 0.1, False, False),
        ((0.0, 0.0, 0.0), SILENT_S + 0.1, False, True),
        ((0.5, 0.0, 0.0), SILENT_S + 0.1, True, True),
    ):
        now += 100.0
        gate.command((0.0, 0.0, 0.0), now, by_hand=by_hand)
        gate.command(velocity, now, by_hand=by_hand)
        assert gate.velocity(now + pause) is None
        why = gate.command((0.5, 0.0, 0.0), now + pause, by_hand=by_hand)
        assert (why == "") is may, (velocity, pause, by_hand)
        gate.command((0.0, 0.0, 0.0), now + pause, by_hand=by_hand)
    gate.command((0.5, 0.0, 0.0), now)
    gate.held = True
    gate.velocity(now)
    gate.held = False
    assert not gate.command((0.5, 0.0, 0.0), now + 100.0), "it was held and re-armed meanwhile"


def test_once_its_agent_is_gone_nothing_passes():
    gate = Gate(DRIVE, TIMEOUT, 0.0)
    now, _ = driven(gate, 0.0, (0.5, 0.0, 0.0), 1.0)
    gate.closed = gate.held = gate.insists = True
    _, sent = driven(gate, now, (0.5, 0.0, 0.0), REST_S + 0.5)
    assert sent[0] == NO_VELOCITY
    assert sent[-1] is None
