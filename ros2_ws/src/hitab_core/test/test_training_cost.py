"""The cost of a training grows while a person may work on it, and not otherwise."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from hitab_core.agent import Agent
from hitab_core.assistant import training_costs, unsaved_cost
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.notebook.plain import plain_domain
from hitab_core.term import Term
from hitab_core.training import Curriculum

DOMAIN = plain_domain("line", ["Left", "Right"], ["x"])
MINUTE = 60.0


class Day:
    """A clock that a test turns, and an agent whose process may end and start again."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.now = time.time()
        self.agent = self.start()

    def start(self) -> Agent:
        library = BehaviorLibrary(self.folder / "library", DOMAIN)
        self.agent = Agent("ann", DOMAIN, library, self.folder / "state")
        return self.agent

    def end(self) -> None:
        self.agent.journal.close()

    def passes(self, minutes: float) -> None:
        self.now += minutes * MINUTE

    def begin(self) -> None:
        self.agent.begin(Curriculum("Chase", (Term("x"),)))
        self.agent.sense([0.0], [])

    def minutes(self) -> list[float]:
        return [round(c.wall_seconds / MINUTE, 1) for c in training_costs(self.agent.journal)]


@pytest.fixture
def day(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Day:
    made = Day(tmp_path)
    monkeypatch.setattr(time, "time", lambda: made.now)
    return made


def test_a_training_in_which_nothing_was_done_is_not_counted(day: Day) -> None:
    day.begin()
    day.passes(2)
    assert day.minutes() == []
    day.agent.command(Term("Left"))
    assert day.minutes() == [2.0]


def test_the_clock_of_a_training_runs_until_it_is_given_up(day: Day) -> None:
    day.begin()
    day.agent.command(Term("Left"))
    day.passes(1)
    assert day.minutes() == [1.0]
    day.agent.discard()
    day.passes(3)
    assert day.minutes() == [1.0]


def test_the_time_while_the_process_is_down_does_not_count(day: Day) -> None:
    day.begin()
    day.passes(1)
    day.agent.command(Term("Left"))
    day.end()
    day.passes(3)
    day.start().sense([0.0], [])
    assert day.agent.session is not None
    assert day.minutes() == [1.0]
    day.passes(2)
    assert day.minutes() == [3.0]
    day.agent.command(Term("Right"))
    day.agent.save()
    day.passes(4)
    assert day.minutes() == [3.0]


def test_a_training_is_unsaved_from_its_beginning_until_it_is_saved_or_given_up(
    day: Day,
) -> None:
    assert unsaved_cost(day.agent.journal) is None
    for ends in (day.agent.save, day.agent.discard):
        day.begin()
        day.agent.command(Term("Left"))
        unsaved = unsaved_cost(day.agent.journal)
        assert unsaved is not None
        assert unsaved.automaton == "Chase"
        ends()
        assert unsaved_cost(day.agent.journal) is None
