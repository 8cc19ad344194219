"""Agents on three machines end as undisturbed ones, whatever is killed, lost and cut off."""

import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

from lossy_network import why_not

PROGRAM = Path(__file__).resolve().parents[1] / "machines.py"


@pytest.mark.long
@pytest.mark.timeout(1200)
@pytest.mark.skipif(bool(why_not()), reason=why_not())
def test_thirty_agents_end_as_undisturbed_ones():
    options = "--agents 30 --rate 5 --kills 6 --cuts 10 --seconds 5 --domain 61"
    done = subprocess.run(
        [sys.executable, PROGRAM, *options.split()],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert " 0 differ" in done.stdout
