"""A training of more than a few commands is not discarded on a terminal without a question."""

import contextlib
from types import SimpleNamespace

import pytest
from hitab_msgs.msg import AgentStatus, TrainingStatus
from typer.testing import CliRunner

from hitab_cli.main import make_app
from hitab_cli.verbs import operating
from hitab_cli.verbs.train import training_verbs as training
from hitab_core.operations import DiscardTraining


@pytest.fixture
def discarded(monkeypatch) -> list[str]:
    """Return the agents whose trainings were discarded; keeper_1 has 14 examples, keeper_2 two."""
    done: list[str] = []

    def do(agent, operation):
        assert operation == DiscardTraining()
        done.append(agent)
        return SimpleNamespace(message="discarded", remedies=[])

    def status(agent):
        several = agent == "keeper_1"
        return AgentStatus(
            agent=agent,
            mode=AgentStatus.PERFORMING if several else AgentStatus.TRAINING,
            behavior="Rest" if several else "Chase",
            training=TrainingStatus(
                automaton="Chase",
                examples=14 if several else 2,
                default_examples=7 if several else 1,
            ),
        )

    agents = SimpleNamespace(do=do, await_agent=status)
    monkeypatch.setattr(
        operating,
        "connection",
        lambda swarm: contextlib.nullcontext(SimpleNamespace(agents=agents)),
    )
    monkeypatch.setattr(training, "_is_terminal", lambda: True)
    return done


def hitab(*arguments: str, answer: str = ""):
    return CliRunner().invoke(make_app(), arguments, input=answer)


def test_it_asks_before_it_discards_many_examples(discarded):
    refused = hitab("discard", "keeper_1", answer="n\n")
    assert refused.exit_code == 1
    assert 'Discard the training of "Chase" with its 14 unsaved examples? [y/N]' in refused.stderr
    assert discarded == []
    assert hitab("discard", "keeper_1", answer="y\n").exit_code == 0
    assert discarded == ["keeper_1"]


def test_it_does_not_ask_about_a_few_or_if_it_may_not(discarded, monkeypatch):
    assert hitab("discard", "keeper_2").exit_code == 0
    assert hitab("discard", "keeper_1", "--yes").exit_code == 0
    monkeypatch.setattr(training, "_is_terminal", lambda: False)
    assert hitab("discard", "keeper_1").exit_code == 0
    assert discarded == ["keeper_2", "keeper_1", "keeper_1"]
