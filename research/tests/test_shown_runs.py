"""What is measured of runs without commands."""

from __future__ import annotations

from shown_runs import to_the_ball


def test_a_program_without_noise_is_copied_as_by_commands():
    found = to_the_ball(seed=1, noise=0.0, shown=3, episodes=3)
    assert found["labels right, %"] == 100
    assert found["without commands"] == found["with commands"]
    assert found["without commands"] < found["zero examples"]
