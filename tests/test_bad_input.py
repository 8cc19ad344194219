"""Bad input is refused with the way out: in status, service reply and command line alike."""

import pytest

from hitab_client.errors import SwarmError
from hitab_client.swarm_client import SwarmClient
from hitab_client.world_client import WorldClient

AGENT = "keeper_1"


@pytest.fixture(scope="module")
def training(keepers):
    """The swarm, with keeper_1 training; what is refused must not change it."""
    keepers.agents.begin(AGENT, "Near", features=["DistanceTo(ball)"])
    keepers.agents.command(AGENT, "GoFast")
    return keepers


COMMANDS = [
    (("GoFats", []), 'unknown behavior "GoFats" (known: GetOpen, GoFast'),
    (("GoFast", ["ball"]), 'behavior "GoFast" takes no targets, not 1; write GoFast'),
    (("Start", []), "Start cannot be commanded"),
    (("Near", []), "recursive automaton"),
    (("Done", ["ball"]), 'flag state "Done" takes no targets'),
    (("Go(to", []), '"Go(to" is not a use of a behavior'),
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
    ({"automaton": "GoFast"}, '"GoFast" is a basic behavior'),
    ({"automaton": "Start"}, "reserved"),
    ({"automaton": "A", "features": ["DistanceTo(bal)"]}, 'unknown target "bal"'),
    (
        {"automaton": "A", "features": ["DistanceTo(X)"]},
        "if it is a parameter, give the target that it stands for in training, as `-p X=TARGET`",
    ),
    (
        {"automaton": "A", "features": ["DistanceTo"]},
        "takes 1 target, not 0; write, for example, DistanceTo(ball)",
    ),
    ({"automaton": "A", "features": ["Distance(ball)"]}, 'unknown feature "Distance"'),
    ({"automaton": "A", "states": ["GoFats"]}, 'unknown behavior "GoFats"'),
    ({"automaton": "A", "parameters": ["B"]}, "1 parameter but 0 targets"),
    ({"automaton": "A", "resume": "Nothing"}, 'unknown behavior "Nothing"'),
    ({"automaton": "A", "discard": False}, "2 unsaved examples; save it first (`hitab save "),
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
        assert len(training.agents.list_examples(AGENT).examples) == 2


def test_commands_in_the_wrong_mode_are_refused(training):
    agents = training.agents
    agents.set_mode(AGENT, "testing", restart=True)
    try:
        with pytest.raises(
            SwarmError, match=r"being tested; go to training mode to take over .*hitab train "
        ):
            agents.command(AGENT, "GoFast")
    finally:
        agents.set_mode(AGENT, "training")
    with pytest.raises(SwarmError, match="is not training anything; begin a training first"):
        agents.command("keeper_2", "GoFast")
    with pytest.raises(SwarmError, match="is not training anything"):
        agents.save("keeper_2")
    with pytest.raises(SwarmError, match="is not training anything"):
        agents.set_mode("keeper_2", "testing")
    with pytest.raises(SwarmError, match='unknown mode "resting"'):
        agents.set_mode(AGENT, "resting")


def test_wrong_edits_are_refused(training):
    for arguments, expected in (
        (("delete", [99]), r"no example number 99 \(known: 1, 2\)"),
        (("relabel", [1], "GoFats"), 'unknown behavior "GoFats"'),
        (("erase", [1]), 'unknown action "erase"'),
    ):
        with pytest.raises(SwarmError, match=expected):
            training.agents.edit_examples(AGENT, *arguments)


def test_wrong_libraries_and_behaviors_are_refused(training, tmp_path):
    agents = training.agents
    (tmp_path / "Bad.hfa.yaml").write_text("format: 99\nname: Bad\n")
    with pytest.raises(
        SwarmError, match=r"Bad\.hfa\.yaml, cannot be used: line 1: has format version 99"
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
    (lambda w: w.place({"ball": {"x": float("inf")}}), "ball"),
    (lambda w: w.control("dance"), 'unknown action "dance"'),
    (lambda w: w.control("step", cycles=0), "step needs a number of cycles"),
    (lambda w: w.control("pace", pace="slow"), "it must be one of: lockstep, realtime"),
    (lambda w: w.control("pace", factor=float("inf")), "factor is inf; it must be finite"),
    (lambda w: w.snapshot("restore", "nothing"), 'no snapshot "nothing"'),
    (lambda w: w.snapshot("save"), "a snapshot needs a name"),
]


def test_the_world_refuses_what_cannot_be(training):
    for ask, expected in WORLD_ERRORS:
        with pytest.raises(SwarmError, match="the world refuses") as error:
            ask(training.world)
        assert expected in str(error.value)
        assert training.world.step().world == "keepaway"


def test_a_world_keeps_a_bounded_number_of_snapshots(training):
    kept = []
    try:
        for number in range(100):
            training.world.snapshot("save", f"s{number}")
            kept.append(f"s{number}")
        with pytest.raises(SwarmError, match="there are 100 snapshots; delete one of them first"):
            training.world.snapshot("save", "one more")
        training.world.snapshot("save", "s0")  # again, which takes no more room
    finally:
        for name in kept:
            training.world.snapshot("delete", name)


def test_nothing_was_lost_by_all_that(training):
    assert len(training.agents.list_examples(AGENT).examples) == 2
    assert training.agents.command(AGENT, "Stop").examples == 4


def test_a_missing_world_and_missing_agents_are_told(training):
    nobody = SwarmClient(training.link, prefix="/elsewhere")
    with pytest.raises(SwarmError, match="no other does; `hitab up` starts a swarm"):
        nobody.await_agent(AGENT, seconds=0.2)
    with pytest.raises(SwarmError, match="no world answers; is a swarm with a world up"):
        WorldClient(training.link, prefix="/elsewhere").wait(0.2)


def test_a_second_agent_of_the_same_name_is_refused(training, tmp_path):
    import subprocess

    from hitab_bringup.supervision import environment
    from hitab_bringup.swarm_description import AgentDescription, SwarmDescription
    from hitab_bringup.swarm_processes import processes
    from hitab_ros.exit_codes import FINAL

    twin = AgentDescription(AGENT, "keepaway", process=AGENT)
    (process,) = processes(SwarmDescription("twins", tmp_path, (twin,)), tmp_path)
    done = subprocess.run(
        process.command,
        env=environment(training.folder, training.record.domain_id),
        capture_output=True,
        text=True,
        timeout=20,
        check=False,
    )
    # Its supervisor must not start it again and again; it says whose the name is.
    assert done.returncode == FINAL
    swarm = training.record.identity
    assert f'error: "{AGENT}" is already running in swarm {swarm}' in done.stderr
    assert training.agents.command(AGENT, "GoFast").mode == "training"
