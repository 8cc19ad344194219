"""An agent says what its words mean, and what undo and redo would change."""

import json

ONE = "keeper_1"


def test_every_behavior_and_feature_is_described(keepers):
    words = keepers.agents.vocabulary(ONE)
    behaviors = {b.name: b.description for b in words.behaviors}
    assert behaviors["TurnToBall"] == "turn to face the ball"
    features = {f.name: f.description for f in words.features}
    assert features["DistanceTo(X)"] == "distance to X"
    assert all(features.values())


def test_the_command_shows_the_descriptions(keepers, hitab):
    shown = hitab("vocabulary", ONE)
    assert shown.returncode == 0, shown.stderr
    lines = shown.stdout.splitlines()
    assert "behavior  TurnToBall  turn to face the ball" in lines
    assert "feature   DistanceTo(X)  continuous, m: distance to X" in lines
    assert any(line.startswith("behavior  Pass  one-shot: kick") for line in lines)
    told = json.loads(hitab("vocabulary", ONE, "--json", "-").stdout)
    assert {"name": "TurnToBall", "description": "turn to face the ball"} in told["behaviors"]


def test_the_history_of_a_training_is_told(keepers):
    agents = keepers.agents
    agents.begin(ONE, "Told", features=["DistanceTo(ball)"], discard=True)
    agents.command(ONE, "GoFast")
    agents.command(ONE, "Stop")
    agents.edit_examples(ONE, "delete", [4])
    agents.edit_examples(ONE, "undo")
    agents.edit_examples(ONE, "undo")
    listed = agents.list_examples(ONE)
    assert list(listed.done) == ["Start → GoFast, 2 examples"]
    assert list(listed.undone) == [
        "GoFast → Stop, 2 examples; superseded example 2",
        "deleted example 4",
    ]
    saved = agents.save(ONE)
    assert saved.success
    assert not agents.list_examples(ONE, "Told").done, "what is saved has no history"
