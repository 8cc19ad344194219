"""The records at full speed: trained keepers beside rules, over the same episodes."""

import json
import subprocess
import sys
from pathlib import Path

RECORDS = Path(__file__).parents[1] / "records.py"


def ran(script: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(script), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=100)


def test_the_records_compare_trained_keepers_and_rules_over_the_same_episodes(tmp_path):
    path = tmp_path / "r.json"
    done = ran(
        RECORDS, "--episodes", "2", "--longest", "4", "--sight", "full", "--json", str(path)
    )
    assert done.returncode == 0, done.stderr
    figures = json.loads(path.read_text())["full"]
    assert [len(team["seconds"]) for team in figures.values()] == [2, 2]
    assert "trained (31 examples), GetOpen - rules (near 4.5, slack 0.2), GetOpen:" in done.stdout

    plot, server = tmp_path / "r.png", tmp_path / "server.json"
    server.write_text('{"each_seconds": [3.0, 40.0, 700.0]}')
    drawn = ran(RECORDS.with_name("records_plot.py"), path, "--full", server, "--plot", plot)
    assert drawn.returncode == 0, drawn.stderr
    assert plot.read_bytes().startswith(b"\x89PNG")


def test_the_records_refuse_a_way_of_seeing_that_there_is_not():
    done = ran(RECORDS, "--sight", "none")
    assert done.returncode == 2
    assert "none" in done.stderr
    assert "Traceback" not in done.stderr
