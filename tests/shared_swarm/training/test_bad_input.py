"""Bad input is refused with the way out: in status, service reply and command line alike."""

import pytest

from hitab_client.errors import SwarmError
from hitab_client.swarm_client import SwarmClient
from hitab_client.world_client import WorldClient
from hitab_core import Fix
from hitab_core.operations import (
    BeginTraining,
    Command,
    Distribute,
    LoadLibrary,
    Perform,
    SaveBehavior,
    TakeOver,
    Test,
)

AGENT = "keeper_1"


@pytest.fixture(scope="module")
def training(keepers):
    """The swarm, with keeper_1 training; what is refused must not change it."""
    keepers.agents.do(AGENT, BeginTraining("Near", features=["DistanceTo(ball)"]))
    keepers.agents.do(AGENT, Command("GoFast"))
    return keepers


COMMANDS = [
    (("GoFats", []), 'unknown behavior "GoFats" (known: GetOpen, GoFast'),
    (("Start", []), "Start cannot be commanded"),
    (("Near", []), "recursive automaton"),
]


def test_a_wrong_command_is_refused_in_the_status(training):
    for command, expected in COMMANDS:
        with pytest.raises(SwarmError) as error:
            training.agents.do(AGENT, Command(*command))
        assert expected in str(error.value)
        status = training.agents.statuses[AGENT]
        assert expected in status.last_error
        assert status.training.examples == 2


BEGINNINGS = [
    ({"automaton": "1st"}, '"1st" is not a name'),
    ({"automaton": "A", "features": ["DistanceTo(bal)"]}, 'unknown target "bal"'),
    (
        {"automaton": "A", "features": ["DistanceTo(X)"]},
        "if it is a parameter, give the target that it stands for in training, as `-p X=TARGET`",
    ),
    ({"automaton": "A", "resume": "Nothing"}, 'unknown behavior "Nothing"'),
    ({"automaton": "A", "discard": False}, "2 unsaved examples"),
]


def test_a_wrong_training_is_refused_in_the_reply_and_the_status(training):
    for fields, expected in BEGINNINGS:
        with pytest.raises(SwarmError) as error:
            training.agents.do(AGENT, BeginTraining(**{"discard": True, **fields}))
        assert expected in str(error.value)
        assert expected in training.agents.statuses[AGENT].last_error
        assert len(training.agents.training(AGENT).examples) == 2


def test_commands_in_the_wrong_mode_are_refused(training):
    agents = training.agents
    agents.do(AGENT, Test(restart=True))
    try:
        with pytest.raises(SwarmError, match='"Near" is being tested') as refused:
            agents.do(AGENT, Command("GoFast"))
        assert refused.value.remedies == (Fix.RESUME(agent=AGENT),)
    finally:
        agents.do(AGENT, TakeOver())
    with pytest.raises(SwarmError, match="keeper_2: it is not training anything"):
        agents.do("keeper_2", Command("GoFast"))
    with pytest.raises(SwarmError, match="is not training anything"):
        agents.do("keeper_2", SaveBehavior())
    with pytest.raises(SwarmError, match="is not training anything"):
        agents.do("keeper_2", Test())


def test_wrong_libraries_and_behaviors_are_refused(training, tmp_path):
    agents = training.agents
    (tmp_path / "Bad.hfa.yaml").write_text("format: 99\nname: Bad\n")
    with pytest.raises(
        SwarmError, match=r"cannot be used: Bad\.hfa\.yaml:1: has format version 99"
    ):
        agents.do("keeper_2", LoadLibrary(str(tmp_path)))
    for folder in ("nowhere", "~nobody/library", str(tmp_path / "Bad.hfa.yaml")):
        with pytest.raises(SwarmError, match="is not a folder"):
            agents.do("keeper_2", LoadLibrary(folder))
    with pytest.raises(SwarmError, match=r"but no behaviors .* give the path of a library"):
        agents.do("keeper_2", LoadLibrary("/"))  # what is saved next would be written there
    with pytest.raises(SwarmError, match='unknown behavior "Dance"'):
        agents.do("keeper_2", Perform("Dance"))
    with pytest.raises(SwarmError, match='"Dance"'):
        agents.distribute("keeper_2", Distribute("Dance"))
    assert agents.statuses["keeper_2"].mode == "idle"


WORLD_ERRORS = [
    (lambda w: w.place({"bal": {"x": 1.0}}), "bal"),
    (lambda w: w.control("dance"), 'unknown action "dance"'),
    (lambda w: w.control("pace", factor=float("inf")), "factor is inf; it must be finite"),
    (lambda w: w.snapshot("restore", "nothing"), 'no snapshot "nothing"'),
]


def test_the_world_refuses_what_cannot_be(training):
    for ask, expected in WORLD_ERRORS:
        with pytest.raises(SwarmError, match="the world refuses") as error:
            ask(training.world)
        assert expected in str(error.value)
        assert training.world.step().world == "keepaway"


def test_nothing_was_lost_by_all_that(training):
    assert len(training.agents.training(AGENT).examples) == 2
    assert training.agents.do(AGENT, Command("Stop")).status.training.examples == 4


def test_clients_take_no_other_swarms_robots_for_their_own(training):
    mine, other = "mine-00000000", training.record.identity
    agents = SwarmClient(training.link, (AGENT,), identity=mine)
    with pytest.raises(SwarmError, match=f"{AGENT} belongs to swarm {other}, not to swarm {mine}"):
        agents.do(AGENT, BeginTraining("Stolen", features=["Done"]))
    with pytest.raises(SwarmError, match=f"{other}, not to swarm {mine}"):
        WorldClient(training.link, identity=mine).control("resume")
    assert training.agents.await_agent(AGENT).behavior == "Near"
    assert training.world.wait().mode == "paused"
