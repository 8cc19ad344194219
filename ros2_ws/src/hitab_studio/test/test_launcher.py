"""Swarms are started with the command, whose output is kept."""

import asyncio
import sys
import time

import pytest

from hitab_client.errors import SwarmError
from hitab_studio.swarm.launcher import Launcher, command, startable_swarms


def run(script: str, monkeypatch, after=lambda launcher: None) -> Launcher:
    """Run a script in place of the command until it ends."""
    monkeypatch.setattr(
        "hitab_studio.swarm.launcher.command", lambda: [sys.executable, "-c", script]
    )

    async def term() -> Launcher:
        launcher = Launcher()
        launcher.run("up", "keepaway")
        after(launcher)
        deadline = time.monotonic() + 60.0
        while launcher.is_busy:
            assert time.monotonic() < deadline
            await asyncio.sleep(0.01)
        return launcher

    return asyncio.run(term())


def test_what_a_command_that_fails_has_said_is_kept_until_it_is_dismissed(monkeypatch):
    launcher = run("import sys; print('error: no room'); sys.exit(1)", monkeypatch)
    assert launcher.launch is not None
    assert (launcher.launch.status, launcher.launch.lines) == (1, ["error: no room"])
    launcher.dismiss()
    assert launcher.launch is None


def test_one_command_runs_at_a_time(monkeypatch):
    def again(launcher: Launcher) -> None:
        with pytest.raises(SwarmError, match="keepaway is being started"):
            launcher.run("down", "keepaway")

    run("pass", monkeypatch, again)


def test_a_command_that_is_not_there_is_named(monkeypatch):
    monkeypatch.setattr("hitab_studio.swarm.launcher.entry_points", lambda **_: ())
    with pytest.raises(SwarmError, match="install HiTAB again"):
        command()


def test_the_shipped_swarms_can_be_started_with_what_they_are():
    about = startable_swarms()
    assert about["keepaway"].startswith("Three keepers against two takers")
    assert [*startable_swarms("keepaway")] == ["keepaway"]
    assert startable_swarms("nothing") == {}
