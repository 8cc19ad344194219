"""Who owes a commander a report in a round of lockstep."""

import pytest

from hitab_commander.roll_call import LATE_ROUNDS_MAX, RollCall


@pytest.fixture
def roll():
    return RollCall(["a", "b"])


def test_a_round_is_complete_once_when_all_have_reported(roll):
    assert not roll.take("a", 7)
    assert roll.take("b", 7)
    assert not roll.take("b", 7)
    assert not roll.take("a", 8)
    assert roll.take("b", 8)


def test_who_lets_a_round_pass_is_not_waited_for_until_it_reports(roll):
    roll.take("a", 1)
    assert roll.take("a", 2), "b let round 1 pass"
    assert set(roll.missing) == {"b"}
    assert not roll.take("b", 1), "late, and alive"
    assert not roll.take("a", 3)
    assert roll.take("b", 3)
    assert not roll.missing


def test_who_let_a_pause_pass_is_waited_for_when_play_begins(roll):
    """Its world waits for it, too: the decision would depend on whose message came first."""
    roll.take("a", 1, look=True)
    assert roll.take("a", 2, look=True), "b let round 1 pass"
    assert not roll.take("a", 3)
    assert not roll.take("b", 2, look=True), "late, and alive"
    assert roll.take("b", 3)


def test_a_late_report_does_not_bring_back_the_round_that_it_is_about(roll):
    roll.take("a", 5)
    roll.take("b", 5)
    roll.take("a", 6)
    assert not roll.take("a", 5)
    assert roll.round == 6
    assert roll.take("b", 6)


def test_a_world_that_counts_anew_and_a_forged_number_end_nothing(roll):
    for member in "ab":
        roll.take(member, 2**64 - 1)
    roll.take("a", 10)
    assert roll.round == 10
    assert roll.take("b", 10)
    assert LATE_ROUNDS_MAX < 2**64 - 1


def test_who_was_silent_in_real_time_owes_nothing_until_it_reports(roll):
    roll.begin(["b"])
    assert roll.take("a", 1)
    assert not roll.take("b", 1), "the round was complete already"
    assert not roll.take("a", 2)
    assert roll.take("b", 2)
