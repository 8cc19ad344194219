"""Distinguishes swarms in the same ROS domain.

`hitab up` gives each swarm an identity, which all of its nodes publish in their statuses.
"""

from __future__ import annotations

import re
import secrets

BY_HAND = "nodes started by hand"
"""Stands for all nodes that no `hitab up` has started, in place of a swarm's identity."""

LAUNCHED = "launch:"
"""Begins the identity of a swarm that ``ros2 launch`` has started, which no registry knows."""


def new_identity(swarm: str, *, launched: bool = False) -> str:
    """Return an identity for a new swarm, unique to this start.

    Args:
        swarm: its name.
        launched: whether it was started without `hitab up`.
    """
    return f"{LAUNCHED if launched else ''}{swarm}-{secrets.token_hex(4)}"


def is_identity(text: str) -> bool:
    """Whether a text has the form of an identity."""
    return re.fullmatch(r"\S+-[0-9a-f]{8}", text) is not None


def is_by_hand(heard: str) -> bool:
    """Whether a node was started without `hitab up`.

    Args:
        heard: the identity in its status.
    """
    return not heard or heard.startswith(LAUNCHED)


def is_own(heard: str, meant: str, *, started_by_it: bool) -> bool:
    """Whether a node belongs to the swarm in question.

    Args:
        heard: the identity in its status; empty: it was started by hand.
        meant: the identity of the swarm in question, or `BY_HAND`; empty: any.
        started_by_it: whether that swarm has started a node of this name.
    """
    if not meant or heard == meant:
        return True
    if meant == BY_HAND:
        return is_by_hand(heard)
    return not heard and not started_by_it


def other_swarm(node: str, heard: str, meant: str) -> str:
    """Return an error text for a node of another swarm than the one in question."""
    from hitab_client.run_folder import registered_swarms  # which needs `is_identity`

    left = [record.swarm for _, record in registered_swarms() if record.identity == heard]
    if meant == BY_HAND and left:
        return (
            f'{node} is left of swarm "{left[0]}", which has ended without `hitab down`; '
            f"`hitab down {left[0]}` ends what is left of it, and `hitab up` starts it again"
        )
    if meant == BY_HAND:
        return (
            f"{node} belongs to swarm {heard}, which was not started from here (another "
            f"HITAB_HOME, user or computer); to use it nevertheless, add --swarm {heard}"
        )
    if not heard:
        return (
            f"{node} was started by hand and does not belong to swarm {meant}; "
            "stop one of the two, or start it in another ROS_DOMAIN_ID"
        )
    return (
        f"{node} belongs to swarm {heard}, not to swarm {meant}; choose the swarm with "
        "--swarm NAME, or stop one of the two with `hitab down NAME`"
    )
