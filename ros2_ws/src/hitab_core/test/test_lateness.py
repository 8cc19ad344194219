"""How late a person is, and what late commands were meant for, is learned from the commands."""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from random import Random

import pytest

from hitab_core import Agent, BehaviorLibrary, Given, Term, TrainingError, plain_domain
from hitab_core.assistant.lateness import Lateness
from hitab_core.domain import Feature, FeatureKind
from hitab_core.example import Example
from hitab_core.training import Curriculum

DOOR = Feature("Door", lambda body: body.percept[2], kind=FeatureKind.BOOLEAN)
CART = plain_domain("cart", {"Go": [1.0], "Turn": [0.0]}, ["Distance", "Weather", DOOR])
STEP = 0.05
WALL = 3.0
"""The person means: turn when the wall is nearer than this, m."""


class Course:
    """A cart that runs at a wall, again and again, each time at another speed."""

    def __init__(self, folder: Path, seed: int = 1, *, doors: bool = False) -> None:
        self.folder, self.random, self.time, self.cycle = folder, Random(seed), 0.0, 0
        self.agent = self.made()
        self.door, self.features = 0.0, tuple(map(Term, ("Distance", "Weather", "Door")))
        self.agent.begin(Curriculum("Bounce", self.features[: 2 + doors]))

    def made(self) -> Agent:
        library = BehaviorLibrary(self.folder / "library", CART)
        return Agent("cart", CART, library, self.folder / "journal")

    def sense(self, distance: float, *, jumped: bool = False) -> None:
        self.cycle += 1
        self.time += STEP
        percept = [distance, self.random.random(), self.door]
        self.agent.sense(percept, [], self.cycle, self.time, jumped=jumped)
        self.agent.tick()

    def run(self, delay: float, pace: float = 1.0, *, lag: int = 0) -> Example:
        """Run at the wall once; the person turns it so late, in seconds of their own.

        The command is on its way for ``lag`` cycles.
        """
        speed = self.random.uniform(1.0, 6.0)
        distance = WALL + speed * self.random.uniform(0.8, 1.5)
        self.sense(distance, jumped=True)
        self.agent.command(Term("Go"))
        while distance > WALL:
            distance -= speed * STEP
            self.sense(distance)
        for _ in range(round(delay * pace / STEP)):
            distance -= speed * STEP
            self.sense(distance)
        seen = self.cycle
        for _ in range(lag):
            distance -= speed * STEP
            self.sense(distance)
        return self.agent.command(Term("Turn"), Given(seen=seen, pace=pace))[0]

    @property
    def turns(self) -> list[Example]:
        assert self.agent.session is not None
        return [
            e for e in self.agent.session.examples if (e.state, e.next_state) == ("Go", "Turn")
        ]

    @property
    def people(self) -> Mapping[str, Lateness]:
        return self.agent.people

    @property
    def estimate(self) -> float:
        return self.agent.people[""].median


@pytest.mark.parametrize("delay", [0.2, 0.6, 1.2])
def test_people_who_are_a_little_and_very_late_are_understood_alike(
    tmp_path: Path, delay: float
) -> None:
    course, noise = Course(tmp_path), Random(2)
    for _ in range(10):
        course.run(delay * noise.lognormvariate(0.0, 0.1))
    assert delay / 1.5 < course.estimate < delay * 1.5
    late = [WALL - e.features[0] for e in course.turns]
    unaware = 3.5 * delay  # by the mean speed
    assert len(late) == 10
    assert math.fsum(map(abs, late)) / 10 < max(0.4, 0.35 * unaware)


def test_a_person_in_time_is_left_alone(tmp_path: Path) -> None:
    course = Course(tmp_path)
    for _ in range(10):
        course.run(0.0)
    assert course.people[""].median < 0.1
    assert all(example.ago <= 2 * STEP for example in course.turns)


def test_while_nothing_tells_how_late_a_person_is_commands_stay(tmp_path: Path) -> None:
    course = Course(tmp_path)
    course.agent.begin(Curriculum("Blind", ()))
    for lag in (0, 4):
        assert course.run(0.5, lag=lag).ago - lag * STEP <= 2 * STEP


def test_what_is_on_its_way_is_no_delay_of_the_person(tmp_path: Path) -> None:
    course = Course(tmp_path)
    for _ in range(8):
        course.run(0.4, lag=12)
    assert course.estimate == pytest.approx(0.4, rel=0.35)
    assert all(abs(e.features[0] - WALL) < 0.7 for e in course.turns)


def test_what_a_person_tells_of_some_commands_shows_how_late_others_are(tmp_path: Path) -> None:
    unaware, told = Course(tmp_path / "unaware"), Course(tmp_path / "told")
    for course in (unaware, told):
        taught = [course.run(0.8) for _ in range(2)]
        if course is told:
            assert course.agent.session is not None
            course.agent.session.retime([example.number for example in taught], 0.8)
        course.run(0.8)
    assert abs(told.estimate - 0.8) < abs(unaware.estimate - 0.8)
    assert told.estimate == pytest.approx(0.8, rel=0.2)


def test_a_paused_world_tells_nothing_of_delays(tmp_path: Path) -> None:
    course = Course(tmp_path)
    for _ in range(5):
        course.run(0.6, pace=0.0)
    assert course.agent.people == {}


def test_what_is_so_or_not_so_draws_the_moment_there(tmp_path: Path) -> None:
    """Each time the door opens at another distance; the person reacts to that, never alike."""
    course, noise = Course(tmp_path, doors=True), Random(3)
    opened = []
    for _ in range(8):
        course.door = 0.0
        course.sense(9.0, jumped=True)
        course.agent.command(Term("Go"))
        wait = noise.randint(10, 40)
        for at in range(wait + round(0.5 * noise.lognormvariate(0.0, 0.25) / STEP)):
            course.door = float(at >= wait)
            course.sense(9.0 - 0.1 * at)
            if at == wait:
                opened.append(course.cycle)
        course.agent.command(Term("Turn"), Given(pace=1.0))
    assert [example.cycle for example in course.turns] == opened


def test_any_wrong_change_of_the_last_seconds_is_corrected(tmp_path: Path) -> None:
    """It leaves Go for Turn, which is wrong; the person takes over half a second later."""
    course = Course(tmp_path)
    course.sense(9.0)
    course.agent.command(Term("Go"))
    course.sense(5.0)
    course.agent.command(Term("Turn"))
    course.agent.test()
    course.agent.restart(1, 1)
    for distance in (*[9.0] * 8, *[5.0] * 10):
        course.sense(distance)
    assert course.agent.active_path == ["Turn"]
    course.agent.take_over()
    taught = course.agent.command(Term("Go"), Given(pace=1.0))[0]
    assert (taught.state, taught.features[0]) == ("Go", 5.0)


def test_what_is_commanded_later_shows_what_was_meant_before(tmp_path: Path) -> None:
    course = Course(tmp_path)
    first = course.run(1.2)
    for _ in range(9):
        course.run(1.2)
    (settled, *_) = course.turns
    assert settled.number == first.number
    assert abs(settled.features[0] - WALL) < abs(first.features[0] - WALL)


def test_the_pace_of_the_world_does_not_make_a_person_slower(tmp_path: Path) -> None:
    estimates = []
    for pace in (1.0, 0.5):
        course = Course(tmp_path / str(pace))
        for _ in range(8):
            course.run(0.6, pace)
        estimates.append(course.estimate)
    assert estimates[0] == pytest.approx(estimates[1], rel=0.35)


def test_a_command_whose_moment_is_known_stays_there(tmp_path: Path) -> None:
    """A script, a paused world, a time that a person has stated or corrected."""
    course = Course(tmp_path)
    session = course.agent.session
    assert session is not None
    exact = course.run(0.0, pace=0.0)
    stated = course.run(0.6)
    session.retime([stated.number], 0.1)
    kept = [exact, next(e for e in session.examples if e.number == stated.number)]
    for _ in range(5):
        course.run(0.6)
    assert [e for e in session.examples if e.number in (exact.number, stated.number)] == kept


def test_undo_takes_back_what_a_command_had_said_about_others(tmp_path: Path) -> None:
    course = Course(tmp_path)
    session = course.agent.session
    assert session is not None
    for _ in range(3):
        course.run(1.0)
    before = session.examples
    course.run(1.0)
    session.undo()
    assert [e for e in session.examples if e.command <= before[-1].command] == list(before)


def test_a_crash_loses_nothing_of_it(tmp_path: Path) -> None:
    course = Course(tmp_path)
    for _ in range(4):
        course.run(0.9)
    assert course.agent.session is not None
    before = course.agent.session.examples
    course.agent.journal.close()
    course.agent = course.made()
    assert course.agent.session is not None
    assert course.agent.session.examples == before
    course.run(0.9)
    assert len(course.turns) == 5


def test_people_are_known_by_name_and_from_one_training_to_the_next(tmp_path: Path) -> None:
    course = Course(tmp_path)
    for _ in range(8):
        course.run(1.2)
    course.agent.save()
    course.agent.begin(Curriculum("Again", (Term("Distance"),)))
    assert course.run(1.2).ago == pytest.approx(course.estimate, abs=0.3)


@pytest.mark.parametrize("kept", ["", "{", "[[1]]", '{"a": 1}', "[]"])
def test_people_are_known_after_a_restart_unless_that_is_damaged(
    tmp_path: Path, kept: str
) -> None:
    course = Course(tmp_path)
    for _ in range(8):
        course.run(1.2)
    course.agent.save()
    estimate = course.estimate
    if kept:
        with closing(sqlite3.connect(tmp_path / "journal" / "agent.db")) as tables, tables:
            tables.execute("UPDATE person SET lateness = ?", (kept,))
    again = course.made()
    assert (again.people == {}) == bool(kept)
    assert kept or again.people[""].median == pytest.approx(estimate, rel=0.01)


@pytest.mark.parametrize("pace", [-1.0, 1e6, math.nan])
def test_a_pace_that_no_world_has_is_refused(tmp_path: Path, pace: float) -> None:
    course = Course(tmp_path)
    course.sense(5.0)
    with pytest.raises(TrainingError, match="pace"):
        course.agent.command(Term("Go"), Given(pace=pace))


def test_a_wrong_beginning_is_corrected_where_it_was_decided(tmp_path: Path) -> None:
    course = Course(tmp_path)
    course.sense(9.0)
    course.agent.command(Term("Go"))
    course.agent.test()
    course.agent.restart(1, 1)
    for _ in range(12):
        course.sense(9.0)
    assert course.agent.active_path == ["Go"]
    course.agent.take_over()
    taught = course.agent.command(Term("Turn"), Given(pace=1.0))[0]
    assert (taught.state, taught.next_state) == ("Start", "Turn")
    assert course.agent.active_path == ["Turn"]
