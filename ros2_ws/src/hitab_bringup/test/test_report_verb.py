"""`hitab report` without a name shows what is being trained."""

from contextlib import contextmanager
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from hitab_bringup.main import make_app
from hitab_bringup.verbs import report as verb
from hitab_client import SwarmError
from hitab_core.training import TrainingCost


class Agents:
    """Agents, each with the number of examples of its training; 0: it has none."""

    def __init__(self, examples: dict[str, int]) -> None:
        self.statuses = {name: SimpleNamespace(examples=n) for name, n in examples.items()}

    def watch_all(self) -> None:
        pass

    def await_agents(self) -> list[str]:
        return sorted(self.statuses)

    def report(self, agent: str, automaton: str) -> list[TrainingCost]:
        if not self.statuses[agent].examples:
            raise SwarmError(f"{agent} is not training anything")
        cost = TrainingCost("Chase", "2026-05-01T12:00:00", 60.0, 9.0, 3, 6, 0, 0, 1, 0, False)
        return [cost]


@pytest.fixture
def reported(monkeypatch):
    """Return a function that reports on such agents."""

    def report(**examples: int):
        @contextmanager
        def connection(swarm):
            yield SimpleNamespace(agents=Agents(examples))

        monkeypatch.setattr(verb, "connection", connection)
        return CliRunner().invoke(make_app(), ["report"])

    return report


def test_the_only_training_is_shown(reported):
    told = reported(keeper_1=0, keeper_2=6).stdout
    assert "Chase, not saved" in told
    assert "keeper_2" not in told


def test_several_trainings_are_shown_with_their_agents(reported):
    head, *rows = reported(keeper_1=6, keeper_2=6, keeper_3=0).stdout.splitlines()
    assert head.split()[0] == "agent"
    assert [row.split()[0] for row in rows] == ["keeper_1", "keeper_2"]


def test_where_nothing_is_trained_the_way_out_is_named(reported):
    assert "`hitab report keeper_1 NAME`" in reported(keeper_1=0, keeper_2=0).stderr
    assert "keeper_1 is not training anything" in reported(keeper_1=0).stderr
    assert "no agent answers" in reported().stderr
