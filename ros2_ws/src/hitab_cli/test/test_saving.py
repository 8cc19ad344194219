"""On a terminal, open questions are shown before a behavior is saved."""

import contextlib
from types import SimpleNamespace

import pytest
from hitab_msgs.msg import AgentStatus, TrainingStatus
from typer.testing import CliRunner

from hitab_cli.main import make_app
from hitab_cli.verbs import operating
from hitab_cli.verbs.train import training_verbs as training
from hitab_core.operations import SaveBehavior

QUESTION = SimpleNamespace(number=4, text="In Start, GoFast and Stop: which holds?")


@pytest.fixture
def saved(monkeypatch) -> list[str]:
    """Return the agents whose behaviors were saved; only keeper_1 has a question."""
    done: list[str] = []

    def do(agent, operation):
        assert operation == SaveBehavior()
        done.append(agent)
        return SimpleNamespace(message="saved", path="Chase.yaml", trimmed=[], remedies=[])

    def status(agent):
        name = "" if agent == "keeper_3" else "Chase"
        return AgentStatus(agent=agent, training=TrainingStatus(automaton=name))

    def asked(agent, *, searched):
        assert searched
        assert agent != "keeper_3", "it trains nothing"
        return SimpleNamespace(questions=[QUESTION] if agent == "keeper_1" else [])

    agents = SimpleNamespace(do=do, await_agent=status, training=asked)
    monkeypatch.setattr(
        operating,
        "connection",
        lambda swarm: contextlib.nullcontext(SimpleNamespace(agents=agents)),
    )
    monkeypatch.setattr(training, "_is_terminal", lambda: True)
    return done


def hitab(*arguments: str, answer: str = ""):
    return CliRunner().invoke(make_app(), arguments, input=answer)


def test_open_questions_are_shown_before_saving(saved):
    refused = hitab("save", "keeper_1", answer="n\n")
    assert refused.exit_code == 1
    assert "4. In Start, GoFast and Stop: which holds?" in refused.stderr
    assert "questions keeper_1` shows the answers" in refused.stderr
    assert "Save with 1 question open? [Y/n]" in refused.stderr
    assert saved == []
    assert hitab("save", "keeper_1", answer="\n").exit_code == 0
    assert saved == ["keeper_1"]


def test_saving_asks_nothing_without_a_question_or_if_it_may_not(saved, monkeypatch):
    for arguments in (("keeper_1", "--yes"), ("keeper_2",), ("keeper_3",)):
        done = hitab("save", *arguments)
        assert done.exit_code == 0
        assert "which holds?" not in done.stderr
    monkeypatch.setattr(training, "_is_terminal", lambda: False)
    assert hitab("save", "keeper_1").exit_code == 0
    assert saved == ["keeper_1", "keeper_2", "keeper_3", "keeper_1"]
