"""Names of all topics and services.

An agent or a world has a namespace with its own name. All of these names are relative to it,
except those of the swarm, which are relative to the enclosing namespace. Programs that talk to a
swarm get full names from `of_agent`, `of_world` and `of_swarm`, whose ``prefix`` is the namespace
of the swarm, such as ``/red``; empty by default.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from hitab_core import Fix, HitabError

if TYPE_CHECKING:
    from rclpy.node import Node

_RELATIVE = re.compile(r"[A-Za-z_]\w*(/[A-Za-z_]\w*)*\Z", re.ASCII)

WORLD = "world"
STATUS_TYPE = "hitab_msgs/msg/AgentStatus"
MACHINE_TYPE = "hitab_msgs/msg/MachineStatus"
STATUS_TYPES = (STATUS_TYPE, "hitab_msgs/msg/WorldStatus")
"""Namespaces of agents and worlds. A swarm has one or both."""

# Of an agent, besides its operations (`hitab_core.operations`), whose services have their names.
COMMAND = "command"
STATUS = "status"
TRANSITIONS = "transitions"
TRAINING = "training"
PERCEPT = "percept"
PERCEIVED = "perceived"  # each percept taken in, for recordings
GET_REPORT = "get_report"
PERFORM_UNTIL_DONE = "perform_until_done"  # an action
GET_VOCABULARY = "get_vocabulary"
GET_BEHAVIOR = "get_behavior"
READ_FEATURES = "read_features"

# Of a commander, in addition to those of an agent.
ORDER = "order"
REPORTS = "reports"
GROUP = "group"

# Of a host of many agents.
PERCEPTS = "percepts"
PERCEPT_PIECES = "percept_pieces"  # in real time, of a host on one of several machines
ORDERS = "orders"  # of the commanders of another host; its reports are on REPORTS

# Of a world; its status topic is also STATUS.
ACTIONS = "actions"
ACTION_BATCHES = "action_batches"
ACTION_PIECES = "action_pieces"
STATE = "state"
EPISODES = "episodes"
CONTROL = "control"
PLAY = "play"
PLACE = "place"
SNAPSHOT = "snapshot"
CLOCK = "/clock"  # absolute, as required by ROS
ROSOUT = "/rosout"  # the same

# Of all robots, whatever their swarm.
EMERGENCY_STOP = "/emergency_stop"
EMERGENCY_STATE = "/emergency_stop/state"
VELOCITY_RELAY = "velocity_relay"
"""Name of the node that passes an agent's velocities on to its robot, in the agent's namespace."""

STOP_STATE = "stop_state"
"""Topic on which a robot's relay, an agent with its own link, or a world reports its stop."""

ARM = "arm"
"""Service of a robot's relay, or of an agent with its own link, that re-arms the robot."""

GOALS = "agent_goals"
"""Topic of an agent's current goals at action servers, in the agent's namespace."""

TELEOP = "cmd_vel_teleop"
"""Topic of velocities from a person to a robot's relay, in the agent's namespace."""

# Of the swarm.
ALIVE = "alive"
OPERATORS = "operators"  # signs of life of people's consoles
HOSTS = "hosts"
STATUSES = "statuses"
COMMANDS = "commands"
DISTRIBUTION = "distribution"
DISTRIBUTION_ACK = "distribution_ack"
MACHINES = "machines"

# Of a machine, in its namespace.
READ_FILES = "read_files"
READ_LOG = "read_log"
RUN_PROCESS = "run_process"
TAKE_DOWN = "take_down"


def own_name(node: Node) -> str:
    """Return the name of a node's agent or world: the last part of its namespace."""
    return node.get_namespace().rsplit("/", 1)[-1] or node.get_name()


def swarm_namespace(node: Node) -> str:
    """Return the namespace of all agents and the world, without a trailing slash."""
    return node.get_namespace().rsplit("/", 1)[0]


def in_swarm(node: Node, *parts: str) -> str:
    """Return a full name in the swarm, as in ``in_swarm(node, "world", "actions")``."""
    return "/".join((swarm_namespace(node), *parts))


def of_agent(agent: str, name: str, prefix: str = "") -> str:
    """Return the full name of an agent's topic or service, such as ``/keeper_1/status``.

    Raises:
        HitabError: if the name is invalid in ROS.
    """
    if _RELATIVE.match(agent) is None:
        raise HitabError(
            f'"{agent}" cannot be the name of an agent: name it without its namespace, such as '
            "keeper_1, and choose its swarm by the swarm's name",
            Fix.STATUS(),
        )
    return f"{prefix}/{agent}/{name}"


def of_host(first: str, machine: str = "") -> str:
    """Return the name of a host by that of its first agent, such as ``host_of_ant_1``.

    Of a swarm on several machines, it names the machine: while agents move, two may run them.
    """
    return f"host_of_{first}_on_{machine}" if machine else f"host_of_{first}"


def of_world(name: str, prefix: str = "") -> str:
    """Return the full name of the world's topic or service, such as ``/world/state``."""
    return f"{prefix}/{WORLD}/{name}"


def of_swarm(name: str, prefix: str = "") -> str:
    """Return the full name of a topic of the swarm, such as ``/distribution_ack``."""
    return f"{prefix}/{name}"


def agent_of_status(topic: str, prefix: str = "") -> str | None:
    """Return the agent of a status topic, or None if it is not ``<prefix>/<agent>/status``."""
    if not topic.startswith(prefix + "/") or not topic.endswith("/status"):
        return None
    agent = topic[len(prefix) + 1 : -len("/status")]
    return agent if agent and "/" not in agent else None
