"""The demo: trains, plays, compares with the paper, and leaves pictures, figures and a library."""

import json
import os
import signal
import subprocess
import sys
import time

import psutil
from keepers import assert_taught_what_is_shipped

from hitab_client.runs.run_folder import MARK
from keepaway_world.demo import DEMO


def test_the_demo_leaves_pictures_figures_and_a_library(hitab, tmp_path):
    folder = tmp_path / "demo"
    done = hitab("demo", "--out", str(folder), "--episodes", "10", timeout=100)
    assert done.returncode == 0, done.stderr
    for name in ("field.png", "automata.png", "episode_lengths.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG")
    figures = json.loads((folder / "figures.json").read_text())
    assert [row["automaton"] for row in figures["lessons"]] == list(DEMO.examples)
    for row in figures["lessons"]:
        assert 0 < row["examples"] <= DEMO.examples[row["automaton"]], "more than in the paper"
        assert_taught_what_is_shipped(folder / "library", "keepaway", row["automaton"])
    assert figures["evaluation"]["episodes"] == 10
    assert hitab("library", "check", "-l", str(folder / "library")).returncode == 0


def test_an_interrupted_demo_leaves_no_process(home, tmp_path):
    temporary = tmp_path / "temporary"
    temporary.mkdir()

    def processes() -> list[psutil.Process]:
        found = []
        for process in psutil.process_iter():
            try:
                if process.environ().get(MARK, "").startswith(str(temporary)):
                    found.append(process)
            except psutil.Error:
                continue
        return found

    command = subprocess.Popen(
        [sys.executable, "-m", "hitab_cli.main", "demo", "--out", str(tmp_path / "out")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "TMPDIR": str(temporary)},
    )
    deadline = time.monotonic() + 30
    while len(processes()) < 5:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    command.send_signal(signal.SIGTERM)
    _, told = command.communicate(timeout=90)
    assert command.returncode == 143, told
    assert "Traceback" not in told
    assert processes() == []
    assert list(temporary.iterdir()) == []
