"""Names of topics and services, in one place.

An agent's names start with its own name and a world's with ``world``; those of the whole swarm
have no owner. ``prefix`` is the namespace of a swarm, such as ``/red``; empty by default.
"""

from __future__ import annotations

WORLD = "world"
STATUS_TYPE = "hitab_msgs/msg/AgentStatus"


def of_agent(agent: str, name: str, prefix: str = "") -> str:
    """Return the full name of an agent's topic or service, such as ``/keeper_1/status``."""
    return f"{prefix}/{agent}/{name}"


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
