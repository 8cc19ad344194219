"""Bad input is refused with the way out: in status, service reply and command line alike."""

import pytest

from hitab_client.errors import SwarmError
from hitab_client.swarm_client import SwarmClient
from hitab_client.world_client import WorldClient
from hitab_core import Fix

AGENT = "keeper_1"


@pytest.fixture(scope="module")
def training(keepers):
    """The swarm, with keeper_1 training; what is refused must not change it."""
    keepers.agents.begin(AGENT, "Near", features=["DistanceTo(ball)"])
    keepers.agents.command(AGENT, "GoFast")
    return keepers


COMMANDS = [
    (("GoFats", []), 'unknown behavior "GoFats" (known: GetOpen, GoFast'),
    (("Start", []), "Start cannot be commanded"),
    (("Near", []), "recursive automaton"),
]


def test_a_wrong_command_is_refused_in_the_status(training):
    for command, expected in COMMANDS:
        with pytest.raises(SwarmError) as error:
            training.agents.command(AGENT, *command)
        assert expected in str(error.value)
        status = training.agents.statuses[AGENT]
        assert expected in status.last_error
        assert status.last_refused_sequence > status.last_command_sequence
        assert status.examples == 2


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


def told(training, expected):
    """Wait until the agent's status says so."""
    statuses = training.agents.statuses
    return training.link.spin_until(lambda: expected in statuses[AGENT].last_error, 5)


def test_a_wrong_training_is_refused_in_the_reply_and_the_status(training):
    for fields, expected in BEGINNINGS:
        automaton = fields.get("automaton")
        rest = {k: v for k, v in fields.items() if k != "automaton"}
        with pytest.raises(SwarmError) as error:
            training.agents.begin(AGENT, automaton, **{"discard": True, **rest})
        assert expected in str(error.value)
        assert told(training, expected)
        assert len(training.agents.training(AGENT).examples) == 2


def test_commands_in_the_wrong_mode_are_refused(training):
    agents = training.agents
    agents.set_mode(AGENT, "testing", restart=True)
    try:
        with pytest.raises(SwarmError, match='"Near" is being tested') as refused:
            agents.command(AGENT, "GoFast")
        assert refused.value.remedies == (Fix.RESUME(agent=AGENT),)
    finally:
        agents.set_mode(AGENT, "training")
    with pytest.raises(SwarmError, match="keeper_2: it is not training anything"):
        agents.command("keeper_2", "GoFast")
    with pytest.raises(SwarmError, match="is not training anything"):
        agents.save("keeper_2")
    with pytest.raises(SwarmError, match="is not training anything"):
        agents.set_mode("keeper_2", "testing")
    with pytest.raises(SwarmError, match='unknown mode "resting"'):
        agents.set_mode(AGENT, "resting")


def test_wrong_libraries_and_behaviors_are_refused(training, tmp_path):
    agents = training.agents
    (tmp_path / "Bad.hfa.yaml").write_text("format: 99\nname: Bad\n")
    with pytest.raises(
        SwarmError, match=r"cannot be used: Bad\.hfa\.yaml:1: has format version 99"
    ):
        agents.load_library("keeper_2", str(tmp_path))
    for folder in ("nowhere", "~nobody/library", str(tmp_path / "Bad.hfa.yaml")):
        with pytest.raises(SwarmError, match="is not a folder"):
            agents.load_library("keeper_2", folder)
    with pytest.raises(SwarmError, match=r"but no behaviors .* give the path of a library"):
        agents.load_library("keeper_2", "/")  # what is saved next would be written there
    with pytest.raises(SwarmError, match='unknown behavior "Dance"'):
        agents.perform("keeper_2", "Dance")
    with pytest.raises(SwarmError, match='"Dance"'):
        agents.distribute("keeper_2", "Dance")
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
    assert training.agents.command(AGENT, "Stop").examples == 4


def test_clients_take_no_other_swarms_robots_for_their_own(training):
    mine, other = "mine-00000000", training.record.identity
    agents = SwarmClient(training.link, (AGENT,), identity=mine)
    with pytest.raises(SwarmError, match=f"{AGENT} belongs to swarm {other}, not to swarm {mine}"):
        agents.begin(AGENT, "Stolen", features=["Done"])
    with pytest.raises(SwarmError, match=f"{other}, not to swarm {mine}"):
        WorldClient(training.link, identity=mine).control("resume")
    assert training.agents.await_agent(AGENT).behavior == "Near"
    assert training.world.wait().mode == "paused"
