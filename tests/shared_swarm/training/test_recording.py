"""What `hitab record` writes survives however it ends, and has the topics that were asked for."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from sensor_msgs.msg import LaserScan
from waiting import within

from hitab_bringup.processes.bringing_up import RunningSwarm
from hitab_client import SwarmError
from hitab_client.recording import RecordedMessages
from hitab_client.recording.reading import MAGIC

SECONDS = 60.0


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGHUP], ids=["kill", "hup"])
def test_what_was_recorded_is_read_after_a_kill_or_a_closed_terminal(
    keepers: RunningSwarm, tmp_path: Path, number: signal.Signals
) -> None:
    bag = tmp_path / "killed.mcap"

    def recorded() -> set[str]:
        with suppress(SwarmError):  # nothing yet
            return {message.topic for message in RecordedMessages(bag)}
        return set()

    wanted = {"/world/status", *(f"/{agent}/status" for agent in keepers.record.agents)}
    command = [sys.executable, "-m", "hitab_cli.main", "record", "-o", str(bag)]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as recorder:
        try:
            assert within(SECONDS, lambda: bag.exists() and wanted <= recorded())
        finally:
            recorder.send_signal(number)
    assert wanted <= recorded()
    assert bag.read_bytes().endswith(MAGIC) == (number == signal.SIGHUP)


def test_the_command_records_chosen_topics_too(
    keepers: RunningSwarm,
    hitab: Callable[..., Any],
    tmp_path: Path,
) -> None:
    bag = tmp_path / "bag.mcap"
    scans = keepers.link.node.create_publisher(LaserScan, "/robot_1/scan", 10, temporary=True)
    done: list[Any] = []
    options = ("-t", "/robot_1/scan", "-t", "robot_1/odom", "--seconds", "4")
    thread = threading.Thread(
        target=lambda: done.append(hitab("record", "-o", str(bag.with_suffix("")), *options))
    )
    thread.start()
    while thread.is_alive():
        scans.publish(LaserScan(ranges=[1.5]))
        keepers.link.spin(0.1)
    keepers.link.node.destroy_publisher(scans)
    assert done[0].returncode == 0, done[0].stderr
    assert f"to {bag}" in done[0].stdout
    assert (
        "the world is paused: nothing changes\n  let the world go on: `hitab world resume`"
        in done[0].stderr
    )
    assert "/robot_1/odom is not in it: no node has published it" in done[0].stderr
    assert "/robot_1/scan" in {message.topic for message in RecordedMessages(bag)}
    again = hitab("record", "-o", str(bag))
    assert f"{bag} exists already" in again.stderr
