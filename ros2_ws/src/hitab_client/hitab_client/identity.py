"""Distinguishes swarms in the same ROS domain.

`hitab up` gives each swarm an identity, which all of its nodes publish in their statuses.
"""

from __future__ import annotations

import secrets


def new_identity(swarm: str) -> str:
    """Return an identity for a new swarm, unique to this start."""
    return f"{swarm}-{secrets.token_hex(4)}"


def is_own(heard: str, meant: str, *, started_by_it: bool) -> bool:
    """Whether a node belongs to the swarm in question.

    Args:
        heard: the identity in its status; empty: it was started by hand.
        meant: the identity of the swarm in question; empty: any.
        started_by_it: whether that swarm has started a node of this name.
    """
    if not meant or heard == meant:
        return True
    return not heard and not started_by_it


def other_swarm(node: str, heard: str, meant: str) -> str:
    """Return an error text for a node of another swarm than the one in question."""
    if not heard:
        return (
            f"{node} was started by hand and does not belong to swarm {meant}; "
            "stop one of the two, or start it in another ROS_DOMAIN_ID"
        )
    return (
        f"{node} belongs to swarm {heard}, not to swarm {meant}; choose the swarm with "
        "--swarm NAME, or stop one of the two with `hitab down NAME`"
    )
