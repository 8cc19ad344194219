"""An agent says what its words mean, and what undo and redo would change."""

ONE = "keeper_1"


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
