"""InspectionServices the swarm that is meant from another one in the same ROS domain.

`hitab up` gives each swarm an identity; all of its nodes have it in their statuses.
"""

from __future__ import annotations

import secrets


def new_identity(swarm: str) -> str:
    """Return an identity for a swarm that is being started: no other start has the same."""
    return f"{swarm}-{secrets.token_hex(4)}"


def is_own(heard: str, meant: str, *, started_by_it: bool) -> bool:
    """Whether a node is part of the swarm that is meant.

    Args:
        heard: the identity that its status gives; empty: it was started by hand.
        meant: the identity of the swarm that is meant; empty: whichever is there.
        started_by_it: whether the swarm has started a node of that name itself.
    """
    if not meant or heard == meant:
        return True
    return not heard and not started_by_it


def other_swarm(node: str, heard: str, meant: str) -> str:
    """Say that a node is part of another swarm than the one that is meant."""
    if not heard:
        return (
            f"{node} was started by hand and is not the one of swarm {meant}, which is meant; "
            "stop one of the two, or start it in another ROS_DOMAIN_ID"
        )
    return (
        f"{node} is part of swarm {heard} here, and swarm {meant} is meant; say which with "
        "--swarm NAME, or stop one of the two with `hitab down --swarm NAME`"
    )
