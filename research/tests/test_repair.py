"""The repair benchmark: a saved team is corrected after the world has changed."""

import pytest
from changed_worlds import CHANGES, NEARER
from correcting import MOST, SHIPPED, corrected, retrained
from repair import passes_from
from repair_table import ratio

from hitab_core import BehaviorLibrary
from keepaway_world.domain import DOMAIN

FAR = CHANGES["players read 1.5 m too far"]


@pytest.fixture
def repaired():
    pupil = corrected(FAR, seed=4)
    yield pupil
    pupil.close()


def test_few_corrections_move_the_threshold_and_keep_all_else(repaired):
    shipped = BehaviorLibrary(SHIPPED, DOMAIN).load()
    learned = repaired.repertoire.automata
    assert 1 <= len(repaired.learning) <= MOST
    assert passes_from(shipped["ControlBall"]) < 3.0
    assert 3.2 < passes_from(learned["ControlBall"]) < 5.0
    assert learned["ControlBall"].examples[:10] == shipped["ControlBall"].examples
    assert learned["Keepaway"].examples == shipped["Keepaway"].examples


def test_a_keeper_that_should_pass_later_must_forget_when_it_passed():
    def distance(**options):
        pupil = corrected(NEARER, seed=4, **options)
        assert len(pupil.learning) <= MOST
        pupil.close()
        return passes_from(pupil.repertoire.automata["ControlBall"])

    assert distance(deletes=False) > 2.0 > distance()


def test_a_team_takes_no_more_commands_than_it_may(repaired):
    begun_again = corrected(FAR, seed=4, afresh=True)
    nothing_saved = retrained(FAR, seed=4, most=MOST)
    assert len(begun_again.learning) == len(nothing_saved.learning) == MOST
    assert "Keepaway" not in nothing_saved.repertoire.automata
    begun_again.close()
    nothing_saved.close()


def test_keepers_misread_the_distances_of_players_only():
    world = FAR.world(FAR.parameters, 3)
    after, _ = world.percept("keeper_1")
    world.offset = 0.0
    before, _ = world.percept("keeper_1")
    changed = [b - a for a, b in zip(before, after, strict=True)]
    assert changed[14::2] == pytest.approx([1.5] * 4)
    assert not any(changed[:14])
    assert not any(changed[15::2])


def test_a_ratio_has_an_interval_over_episodes_and_one_over_people():
    found = ratio([[2.0, 4.0, 6.0], [4.0, 4.0, 4.0]], [[4.0, 8.0, 12.0], [8.0, 8.0, 8.0]])
    assert all(bound == pytest.approx(0.5) for bound in found.values())
    noisy = ratio([[1.0, 5.0], [2.0, 9.0]], [[4.0, 3.0], [8.0, 2.0]])
    assert noisy["low"] < noisy["ratio"] < noisy["high"]
    assert noisy["low_people"] < noisy["ratio"] < noisy["high_people"]
