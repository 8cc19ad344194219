"""What a deleted behavior of a hard-coded team is worth, and what was trained in its place."""

import json
import math
import subprocess
import sys
from pathlib import Path

BENCHMARK = Path(__file__).parents[1] / "deleted_behavior.py"


def measured(folder: Path, episodes: int) -> list[dict]:
    """Return what the benchmark measures of the team: whole, without GotoBall, with it trained."""
    benchmark = [sys.executable, str(BENCHMARK)]
    options = ["--episodes", str(episodes), "--seed", "12", "--json", str(folder / "f.json")]
    done = subprocess.run([*benchmark, *options], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "f.json").read_text())["teams"]


def test_without_it_the_team_is_clearly_worse_and_what_was_trained_restores_it(tmp_path):
    whole, without, trained = measured(tmp_path, 25)
    assert (whole["examples"], without["examples"], trained["examples"]) == (0, 0, 20)
    assert whole["hold_time_s"]["mean"] > 3.0 * without["hold_time_s"]["mean"]
    for figure in ("hold_time_s", "passes"):
        one, other = whole[figure], trained[figure]
        error = math.hypot(one["se"], other["se"])
        assert abs(one["mean"] - other["mean"]) < 2.0 * error
        # Episodes without it are alike, so that they have hardly an error.
        assert other["mean"] - without[figure]["mean"] > 4.0 * other["se"]
