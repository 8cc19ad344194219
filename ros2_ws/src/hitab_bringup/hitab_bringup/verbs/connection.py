"""A verb's connection to the swarm that is up."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hitab_client import RosLink, RunFolder, RunRecord, SwarmClient, WorldClient


@dataclass
class Connection:
    """The agents and the world; also the run folder, if `hitab up` started the swarm."""

    link: RosLink
    agents: SwarmClient
    world: WorldClient
    folder: RunFolder | None = None
    record: RunRecord | None = None


@contextmanager
def connection(swarm: str | None = None) -> Iterator[Connection]:
    """Connect to the named swarm, or the one that is up, or any nodes in the ROS domain.

    Args:
        swarm: its name, identity or run folder.

    Raises:
        SwarmError: if several are up and none is named.
    """
    from hitab_client import RosLink, SwarmClient, WorldClient
    from hitab_client.domain_ids import chosen_by_user
    from hitab_client.swarm_choice import find_meant

    found = find_meant(swarm, chosen_by_user())
    folder, record = found if found else (None, None)
    identity = record.identity if record else ""
    with RosLink(record.domain_id if record else chosen_by_user() or 0) as link:
        agents = SwarmClient(link, record.agents if record else (), identity=identity)
        world = WorldClient(
            link, identity=identity, started_by_it=record.world if record else False
        )
        yield Connection(link, agents, world, folder, record)
