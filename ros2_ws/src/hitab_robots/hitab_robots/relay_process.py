"""The relay of an agent's robot as a process of its own, which outlives the agent."""

from __future__ import annotations

import os
import subprocess
import sys
import time

from hitab_agent import AgentNode
from hitab_robots.settings import COMMANDS, VELOCITY, RelaySettings
from hitab_ros import names

MODULE = "hitab_robots.velocity_relay"

AGAIN_S = 1.0
"""Least time between two starts, s."""

END_S = 3.0
"""How long a relay may take to end, s."""


class RelayProcess:
    """Starts the relay, and starts it again if it ends.

    The names that the agent's node uses hold for the relay: its namespace, and its remappings of
    the topics. If the agent's clock is simulated, so is that by which the relay stamps velocities;
    how long the agent may be silent always counts by the machine's. A relay whose agent has died
    stops the robot and ends.
    """

    def __init__(self, node: AgentNode, settings: RelaySettings) -> None:
        self._command = [
            *(sys.executable, "-m", MODULE, "--ros-args", "--disable-external-lib-logs"),
            *("-r", f"__ns:={node.get_namespace()}"),
            *("-r", f"{COMMANDS}:={node.resolve_topic_name(COMMANDS)}"),
            *("-r", f"{VELOCITY}:={node.resolve_topic_name(VELOCITY)}"),
            *("-p", f"state_dir:={node.settings.state_dir}"),
            *("-p", f"agent_pid:={os.getpid()}"),
            *_simulated_clock(node),
            *settings.arguments(),
        ]
        self._started = 0.0
        self._process = self._start()

    def _start(self) -> subprocess.Popen[bytes]:
        self._started = time.monotonic()
        return subprocess.Popen(self._command, stdin=subprocess.DEVNULL)

    def look_after(self) -> str:
        """Start the relay again if it has ended; return what is wrong, if anything is."""
        status = self._process.poll()
        if status is None:
            return ""
        if time.monotonic() >= self._started + AGAIN_S:
            self._process = self._start()
        return f"the robot's {names.VELOCITY_RELAY} has ended (exit status {status})"

    def end(self) -> None:
        """End the relay, which stops the robot."""
        self._process.terminate()
        try:
            self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def _simulated_clock(node: AgentNode) -> tuple[str, ...]:
    """Return the arguments that give the relay the agent's clock, if that is simulated."""
    if not node.get_parameter("use_sim_time").value:
        return ()
    clock = node.resolve_topic_name("/clock")
    return "-p", "use_sim_time:=true", "-r", f"/clock:={clock}"
