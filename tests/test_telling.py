"""An agent tells what it has learned and what it perceives, to whoever asks."""

import math

import pytest
from hitab_msgs.srv import GetBehavior, ReadFeatures

ONE = "keeper_1"


def place(swarm, distance: float) -> None:
    keeper = {"x": -distance, "y": 0.0, "heading": 0.0, "vx": 0.0, "vy": 0.0}
    ball = {"x": 0.0, "y": 0.0, "vx": 0.0, "vy": 0.0}
    swarm.world.shown(swarm.world.place({ONE: keeper, "ball": ball}))


@pytest.fixture
def begun(keepers):
    features = ["DistanceTo(ball)", "BallIsKickable", "Done"]
    keepers.agents.begin(ONE, "Told", features=features, discard=True)
    return keepers


def told(swarm, **fields):
    return swarm.agents.ask(ONE, GetBehavior, "get_behavior", **fields)


def test_what_an_agent_perceives_is_told_level_by_level(begun):
    place(begun, 5.0)
    read = begun.agents.ask(ONE, ReadFeatures, "read_features", also=["DirectionTo(ball)", "Done"])
    assert [r.automaton for r in read.readings] == ["Told"] * 3 + [""] * 2
    assert [r.feature for r in read.readings][:2] == ["DistanceTo(ball)", "BallIsKickable"]
    values = [r.value for r in read.readings]
    assert values[0] == pytest.approx(5.0, abs=0.5)
    assert values[1:3] == [0.0, 0.0]
    assert math.isnan(values[4])


def test_the_training_under_way_is_told_and_how_it_would_be_saved(begun):
    place(begun, 5.0)
    begun.agents.command(ONE, "GoFast")
    place(begun, 2.0)
    begun.agents.command(ONE, "Stop")
    assert told(begun).origin == GetBehavior.Response.TRAINING
    training = told(begun).automaton
    assert training.name == "Told"
    assert list(training.states) == ["GoFast", "Stop"]
    assert [f.kind for f in training.features] == ["continuous", "boolean", "boolean"]
    assert len(training.examples) == 4
    preview = told(begun, trim=True)
    assert [f.name for f in preview.automaton.features] == ["DistanceTo(ball)"]
    assert len(preview.trimmed) == 2
    assert begun.agents.await_agent(ONE).mode == "training"


def test_versions_and_what_has_changed_between_them_are_told(begun):
    for distance in (5.0, 9.0):
        place(begun, distance)
        begun.agents.command(ONE, "GoFast")
        begun.agents.save(ONE, name="Versioned")
        begun.agents.begin(ONE, "Versioned", resume="Versioned", features=[])
    latest = told(begun, name="Versioned", compare_with=1)
    assert latest.origin == GetBehavior.Response.TRAINED
    assert (latest.version, list(latest.versions)) == (2, [1, 2])
    assert "examples:" in latest.difference
    first = told(begun, name="Versioned", version=1)
    assert len(first.automaton.examples) < len(latest.automaton.examples)


def test_the_history_of_a_training_is_told(keepers):
    agents = keepers.agents
    agents.begin(ONE, "Told", features=["DistanceTo(ball)"], discard=True)
    agents.command(ONE, "GoFast")
    agents.command(ONE, "Stop")
    agents.delete(ONE, [4])
    agents.undo(ONE)
    agents.undo(ONE)
    listed = agents.training(ONE)
    assert list(listed.done) == ["Start → GoFast, 2 examples"]
    assert list(listed.undone) == [
        "GoFast → Stop, 2 examples; superseded example 2",
        "deleted example 4",
    ]
