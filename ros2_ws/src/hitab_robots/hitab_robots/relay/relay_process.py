"""The process of a robot's relay, which outlives the agent that starts it."""

from __future__ import annotations

import os
import subprocess
import sys

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.qos import QoSProfile

from hitab_agent import AgentNode
from hitab_robots.relay.process_state import waits_for_cpu_or_disk
from hitab_robots.settings import AGENT_VELOCITY_TOPIC, BASE_TOPIC, ODOMETRY_TOPIC, RelaySettings
from hitab_ros import names
from hitab_ros.timing import FOUND_S

MODULE = "hitab_robots.relay.velocity_relay"

RELAY_HUNG_S = 0.5
"""Silence, s, after which a relay that is suspended or waits counts as hung. Relays give ten signs
of life a second; a network that loses one in ten loses five in a row once in 10,000 s."""

RELAY_STARVED_S = 2.0
"""The same for a relay that is only starved of CPU or disk, s."""


class RelayProcess:
    """Starts the relay, and reports whether it has ended or hangs (`RelayWatch`).

    The relay gets the namespace and the topic remappings of the agent's node. If the agent's clock
    is simulated, the relay stamps velocities by it too, but always measures the agent's silence by
    the machine's clock. A relay whose agent has died stops the robot and ends.
    """

    def __init__(self, node: AgentNode, settings: RelaySettings, odometry: str) -> None:
        self._command = [
            *(sys.executable, "-m", MODULE, "--ros-args", "--disable-external-lib-logs"),
            *("-r", f"__ns:={node.get_namespace()}"),
            *("-r", f"{BASE_TOPIC}:={node.resolve_topic_name(BASE_TOPIC)}"),
            *("-r", f"{AGENT_VELOCITY_TOPIC}:={node.resolve_topic_name(AGENT_VELOCITY_TOPIC)}"),
            *("-r", f"{ODOMETRY_TOPIC}:={node.resolve_topic_name(odometry)}"),
            *("-p", f"state_dir:={node.settings.state_dir}"),
            *("-p", f"agent_pid:={os.getpid()}"),
            # Outside of a swarm, nothing restarts a killed agent.
            *("-p", f"kills_hung_agent:={str(bool(node.settings.swarm)).lower()}"),
            *_simulated_clock(node),
            *settings.arguments(),
        ]
        self._still = TwistStamped() if settings.drive.enable_stamped_cmd_vel else Twist()
        self._base = None
        if settings.drive.moves:
            self._base = node.create_publisher(type(self._still), BASE_TOPIC, QoSProfile(depth=10))
        self.start()

    def start(self) -> None:
        """Start the relay process."""
        self._process = subprocess.Popen(self._command, stdin=subprocess.DEVNULL)

    def trouble(self, unheard_s: float) -> str:
        """Return the fault of a relay that has ended or hangs; kill it if it hangs.

        Args:
            unheard_s: time since the relay's last sign of life, s.
        """
        status = self._process.poll()
        timeout = RELAY_STARVED_S if waits_for_cpu_or_disk(self._process.pid) else RELAY_HUNG_S
        if status is None and unheard_s < timeout:
            return ""
        if status is None:
            self._process.kill()
            self._process.wait()
        what = "hung" if status is None else f"has ended (exit status {status})"
        return f"the robot's {names.VELOCITY_RELAY} {what}; it is started again"

    def stand_in(self) -> None:
        """Send the base a zero velocity, in the place of a relay that is still starting."""
        if self._base is not None:
            self._base.publish(self._still)

    def end(self) -> None:
        """End the relay; it stops the robot first."""
        self._process.terminate()
        try:
            self._process.wait(FOUND_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def _simulated_clock(node: AgentNode) -> tuple[str, ...]:
    """Return the arguments that give the relay the agent's clock, if it is simulated."""
    if not node.get_parameter("use_sim_time").value:
        return ()
    clock = node.resolve_topic_name("/clock")
    return "-p", "use_sim_time:=true", "-r", f"/clock:={clock}"
