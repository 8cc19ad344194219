"""A verb's connection to the swarm that is up."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hitab_bringup.ros_link import RosLink
    from hitab_bringup.run_folder import RunFolder, RunRecord
    from hitab_bringup.swarm_client import SwarmClient
    from hitab_bringup.world_client import WorldClient


@dataclass
class Connection:
    """The agents and the world; the run folder too, if `hitab up` has started the swarm."""

    link: RosLink
    agents: SwarmClient
    world: WorldClient
    folder: RunFolder | None = None
    record: RunRecord | None = None


@contextmanager
def connection(swarm: str | None = None) -> Iterator[Connection]:
    """Connect to the named swarm, or to the one that is up, or to whatever is in the ROS domain.

    Raises:
        SwarmError: if several are up and none is named.
    """
    from hitab_bringup.domain_ids import chosen_by_user
    from hitab_bringup.ros_link import RosLink
    from hitab_bringup.run_folder import find_running, running_swarms
    from hitab_bringup.swarm_client import SwarmClient
    from hitab_bringup.world_client import WorldClient

    own = chosen_by_user()
    if swarm is None and own is not None:
        there = [found for found in running_swarms() if found[1].domain_id == own]
        found = there[0] if len(there) == 1 else None
        domain_id = own
    else:
        found = find_running(swarm)
        domain_id = found[1].domain_id if found else 0
    folder, record = found if found else (None, None)
    with RosLink(domain_id) as link:
        agents = SwarmClient(link, record.agents if record else ())
        yield Connection(link, agents, WorldClient(link), folder, record)
