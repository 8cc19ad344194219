"""Identities, which distinguish swarms in the same ROS domain.

`hitab up` gives each swarm an identity, which all of its nodes publish in their statuses.
"""

from __future__ import annotations

import hashlib
import json
import re
import secrets
from collections.abc import Iterable

from hitab_client.errors import SwarmError
from hitab_core import Fix

STARTED_BY_HAND = "nodes started by hand"
"""In place of a swarm's identity: all nodes that were started without `hitab up`."""

LAUNCHED = "launch:"
"""Prefix of the identity of a swarm started by ``ros2 launch``, which no registry contains."""


def new_identity(swarm: str, *, launched: bool = False) -> str:
    """Return an identity for a new swarm, unique to this start.

    Args:
        swarm: the swarm's name.
        launched: whether the swarm is started without `hitab up`.
    """
    return f"{LAUNCHED if launched else ''}{swarm}-{secrets.token_hex(4)}"


def shared_identity(swarm: str, namespace: str, machines: Iterable[str]) -> str:
    """Return the identity of a swarm on several machines, the same on each of them.

    Args:
        swarm: the swarm's name.
        namespace: namespace of all nodes.
        machines: names of the machines.
    """
    text = json.dumps([swarm, namespace, *machines])
    return f"{swarm}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"


def is_identity(text: str) -> bool:
    """Whether a text has the form of an identity."""
    return re.fullmatch(r"\S+-[0-9a-f]{8}", text) is not None


def is_by_hand(owner: str) -> bool:
    """Whether a node was started without `hitab up`.

    Args:
        owner: identity in the node's status.
    """
    return not owner or owner.startswith(LAUNCHED)


def is_own(owner: str, chosen: str, *, started_by_it: bool) -> bool:
    """Whether a node belongs to the chosen swarm.

    Args:
        owner: identity in the node's status; empty if it was started by hand.
        chosen: identity of the chosen swarm, or `STARTED_BY_HAND`; empty for any.
        started_by_it: whether that swarm has started a node of this name.
    """
    if not chosen or owner == chosen:
        return True
    if chosen == STARTED_BY_HAND:
        return is_by_hand(owner)
    return not owner and not started_by_it


def other_swarm(node: str, owner: str, chosen: str) -> SwarmError:
    """Return the error for a node of another swarm than the chosen one."""
    from hitab_client.runs.run_folder import (
        registered_swarms,  # circular: it imports `is_identity`
    )

    here = {record.identity: record.swarm for _, record in registered_swarms()}
    left = [here[owner]] if owner in here else []
    if chosen == STARTED_BY_HAND and left:
        return SwarmError(
            f'{node} is left of swarm "{left[0]}", which has ended without being stopped',
            Fix.DOWN(swarm=left[0]),
            Fix.UP(swarm=left[0]),
        )
    if chosen == STARTED_BY_HAND:
        return SwarmError(
            f"{node} belongs to swarm {owner}, which was not started from here (another "
            f"HITAB_HOME, user or computer); to use it nevertheless, add --swarm {owner}"
        )
    other = f"swarm {owner}" if owner else STARTED_BY_HAND
    choose = f"choose the other swarm with --swarm {owner}, or " if owner else ""
    return SwarmError(
        f"{node} belongs to {other}, not to swarm {chosen}; {choose}stop one of the two",
        *(Fix.DOWN(swarm=identity) for identity in (owner, chosen) if identity in here),
    )
