"""A base that was started again is distinguished from programs that only listen."""

from hitab_robots.bases import Bases
from hitab_ros.timing import PROMPT_S

DRIVER, ECHO, RECORDER = "/robot_1/driver", "/_ros2cli_7", "/rosbag2_recorder"


def test_only_a_program_that_was_there_before_has_come_back():
    bases = Bases()
    for takers, back in (
        ({b"2": RECORDER, b"3": ECHO}, set()),
        ({b"1": DRIVER, b"2": RECORDER, b"3": ECHO}, set()),
        ({b"1": DRIVER}, set()),
        ({b"1": DRIVER, b"4": RECORDER, b"5": "/_ros2cli_8"}, set()),
        ({b"4": RECORDER}, set()),
        ({b"4": RECORDER, b"6": DRIVER}, {DRIVER}),
        ({b"4": RECORDER, b"6": DRIVER}, set()),
        # The old one was killed, and is forgotten only later.
        ({b"6": DRIVER, b"7": DRIVER}, {DRIVER}),
        ({b"7": DRIVER}, set()),
    ):
        assert bases.look(takers, 1.0) == back, takers
        assert not bases.unnamed
        assert bases.missing is (DRIVER not in takers.values())


def test_one_whose_name_is_not_known_yet_may_be_the_base_and_does_not_move_meanwhile():
    bases = Bases()
    bases.look({b"1": DRIVER}, 0.0)
    bases.look({}, 10.0)
    assert bases.look({b"2": ""}, 10.1) == set()
    assert bases.unnamed
    assert bases.look({b"2": DRIVER}, 10.2) == {DRIVER}
    assert not bases.unnamed


def test_one_that_is_named_late_has_come_back_all_the_same():
    bases = Bases()
    for takers, now, back in (
        ({}, 0.0, set()),
        ({b"1": ""}, 2 * PROMPT_S, set()),
        ({b"1": DRIVER}, 3 * PROMPT_S, set()),
        ({}, 4 * PROMPT_S, set()),
        ({b"2": "/other"}, 5 * PROMPT_S, set()),
        ({b"2": "/other", b"3": ""}, 7 * PROMPT_S, {""}),
        ({b"2": "/other", b"3": DRIVER}, 8 * PROMPT_S, {DRIVER}),
    ):
        assert bases.look(takers, now) == back, takers


def test_one_that_the_graph_never_names_moves_and_has_come_back_when_it_is_new_again():
    bases = Bases()
    for identity, back in ((b"1", set()), (b"2", {""})):
        assert bases.look({}, 0.0) == set()
        assert bases.look({identity: ""}, PROMPT_S / 2) == set()
        assert bases.unnamed
        assert bases.look({identity: ""}, 2 * PROMPT_S) == back
        assert not bases.unnamed
        bases.look({}, 0.0)


def test_a_program_without_a_name_yet_is_no_base_until_its_name_is_known_or_does_not_come():
    bases = Bases()
    assert bases.look({b"1": ""}, 0.0) == set()
    assert bases.missing, "it may only listen, and a robot that is armed now would stop then"
    bases.look({b"1": "/hitab"}, 0.5)
    assert bases.missing
    bases.look({b"1": "/hitab", b"2": ""}, 1.0)
    bases.look({b"1": "/hitab", b"2": ""}, 1.0 + PROMPT_S)
    assert not bases.missing, "others' nodes may never tell their names"
