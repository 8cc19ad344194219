"""Killing an agent in training loses nothing acknowledged, and does nothing twice."""

import os
import signal

import pytest
from waiting import pid_of

from hitab_client.runs.run_folder import libraries_of
from hitab_core.operations import (
    BeginTraining,
    Command,
    DiscardTraining,
    SaveBehavior,
    Test,
    Undo,
)

AGENT = "keeper_1"
RESTART_SECONDS = 60


def kill(keepers):
    """Kill the agent, and wait for the process after it."""
    killed = pid_of(keepers, AGENT)
    keepers.agents.statuses.pop(AGENT)
    os.kill(killed, signal.SIGKILL)
    assert keepers.link.spin_until(lambda: AGENT in keepers.agents.statuses, RESTART_SECONDS, 0.2)
    assert pid_of(keepers, AGENT) not in (0, killed)


def state(keepers):
    """Return the agent's training with its examples, and the files of its library."""
    training = keepers.agents.statuses[AGENT].training
    examples = keepers.agents.training(AGENT).examples if training.automaton else []
    files = sorted(libraries_of(keepers.folder.path)[AGENT].rglob("*.yaml"))
    return training.automaton, examples, [(file.name, file.read_text()) for file in files]


@pytest.fixture
def training(keepers):
    """The swarm, with keeper_1 in a training of seven examples."""
    keepers.agents.do(AGENT, BeginTraining("Near", features=["DistanceTo(ball)"], discard=True))
    for behavior in ("GoFast", "GoSlow", "Stop", "Pass"):
        answer = keepers.agents.do(AGENT, Command(behavior))
        keepers.world.step()
    assert answer.status.training.examples == 7
    return keepers


def test_no_acknowledged_example_is_lost_by_kill_9(training):
    agents = training.agents
    agents.do(AGENT, Undo())
    before = state(training)
    assert len(before[1]) == 6
    kill(training)
    assert agents.statuses[AGENT].mode == "training"
    assert state(training) == before
    # And it goes on as if nothing had happened.
    training.world.step()
    assert agents.do(AGENT, Command("GoFast")).status.training.examples == 8
    agents.do(AGENT, Test(restart=True))
    agents.do(AGENT, SaveBehavior())


OPERATIONS = [Command("GoFast"), Undo(), SaveBehavior("Again"), DiscardTraining()]


@pytest.mark.parametrize("operation", OPERATIONS, ids=lambda operation: operation.name)
def test_an_operation_whose_answer_was_lost_in_a_crash_is_not_done_twice(training, operation):
    agents, before = training.agents, state(training)
    sent = type(operation)(**{**vars(operation), "id": f"kill-{operation.name}"})
    agents.do(AGENT, sent)
    after = state(training)
    assert after != before
    kill(training)
    assert agents.do(AGENT, sent).message == "done before the restart"
    assert state(training) == after
