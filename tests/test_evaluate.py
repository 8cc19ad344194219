"""`hitab keepaway evaluate`: a seed gives the same episodes, over ROS and in one process."""

import json

FIGURES = {"episodes", "hold_time_s", "passes", "ended", "cycles", "wall_s", "cycles_per_s"}


def test_three_processes_in_lockstep_play_what_one_plays(hitab, tmp_path):
    def evaluate(*options: str) -> dict:
        path = tmp_path / "figures.json"
        command = ("keepaway", "evaluate", "--json", str(path), "--episodes", "4", *options)
        done = hitab(*command, timeout=100)
        assert done.returncode == 0, done.stderr
        assert "hold time" in done.stdout
        return json.loads(path.read_text())

    lockstep = evaluate("--seed", "3")
    assert lockstep.keys() >= FIGURES
    assert lockstep["ended"]["out"] + lockstep["ended"]["taken"] == lockstep["episodes"] == 4
    assert lockstep["missed_deadlines"] == 0
    plot = tmp_path / "lengths.png"
    inprocess = evaluate("--seed", "3", "--pace", "inprocess", "--plot", str(plot))
    for key in ("seconds_of_episodes", "passes", "ended", "cycles", "library_digest"):
        assert inprocess[key] == lockstep[key]
    assert plot.stat().st_size > 1000
    other = evaluate("--seed", "6", "--pace", "inprocess", "--library", "keepaway")
    assert other["library_digest"] == lockstep["library_digest"], "a shipped library has a name"
    assert other["seconds_of_episodes"] != inprocess["seconds_of_episodes"]
