"""Whoever does not answer is named with the reason; nobody else is suggested in its place."""

import os
import pty
import select
import subprocess
import sys

import pytest
from waiting import hanging, within

ONE = "keeper_1"


@pytest.mark.parametrize(
    "call",
    [
        ("demonstrate", ONE, "Stop"),
        ("distribute", "keeper_2", "A", "--to", ONE),
    ],
)
def test_a_suspended_agent_is_named_with_the_way_out(keepers, hitab, call):
    with hanging(keepers, ONE) as pid:
        done = hitab(*call)
    assert done.returncode == 1
    assert (
        f"error: {ONE}'s process is suspended (process {pid}); `kill -CONT {pid}`" in done.stderr
    )
    assert "keeper_3" not in done.stderr


def test_the_watching_status_notices_who_falls_silent(keepers):
    terminal, other_end = pty.openpty()
    environment = {**os.environ, "COLUMNS": "200", "LINES": "50"}
    command = [sys.executable, "-m", "hitab_cli.main", "status", "--watch"]
    watching = subprocess.Popen(
        command, stdin=other_end, stdout=other_end, stderr=other_end, env=environment
    )
    seen = bytearray()

    def shows(text: str) -> bool:
        while select.select([terminal], [], [], 0.0)[0]:
            seen.extend(os.read(terminal, 1 << 16))
        return text.encode() in seen

    try:
        assert within(60, lambda: shows("keeper_3"))
        assert not shows("is suspended")
        with hanging(keepers, "keeper_3") as pid:
            assert within(60, lambda: shows(f"keeper_3's process is suspended (process {pid})"))
    finally:
        watching.kill()
        watching.wait()
        os.close(other_end)
        os.close(terminal)
