"""Names of all topics and services.

An agent and a world each live in a namespace of their own name. All of these names are relative
to it, except those of the swarm, which are relative to the namespace that holds them all.
"""

from __future__ import annotations

from rclpy.node import Node

# Of an agent.
COMMAND = "command"
STATUS = "status"
TRANSITIONS = "transitions"
PERCEPT = "percept"
BEGIN = "begin"
SET_MODE = "set_mode"
EDIT_EXAMPLES = "edit_examples"
LIST_EXAMPLES = "list_examples"
SAVE = "save"
PERFORM = "perform"
LOAD_LIBRARY = "load_library"
DISTRIBUTE = "distribute"
GET_VOCABULARY = "get_vocabulary"
GET_BEHAVIOR = "get_behavior"
READ_FEATURES = "read_features"

# Of a commander, beside those of an agent.
ORDER = "order"
REPORTS = "reports"
GROUP = "group"

# Of a host of many agents.
PERCEPTS = "percepts"

# Of a world; its status topic is called STATUS too.
ACTIONS = "actions"
ACTION_BATCHES = "action_batches"
STATE = "state"
EPISODES = "episodes"
CONTROL = "control"
PLAY = "play"
PLACE = "place"
SNAPSHOT = "snapshot"
CLOCK = "/clock"  # absolute, as ROS wants it

# Of the swarm.
HOSTS = "hosts"
DISTRIBUTION = "distribution"
DISTRIBUTION_ACK = "distribution_ack"


def own_name(node: Node) -> str:
    """Return the name of the agent or world that a node is: the last part of its namespace."""
    return node.get_namespace().rsplit("/", 1)[-1] or node.get_name()


def swarm_namespace(node: Node) -> str:
    """Return the namespace that holds all agents and the world, without a trailing slash."""
    return node.get_namespace().rsplit("/", 1)[0]


def in_swarm(node: Node, *parts: str) -> str:
    """Return the full name of something in the swarm: ``in_swarm(node, "world", "actions")``."""
    return "/".join((swarm_namespace(node), *parts))
