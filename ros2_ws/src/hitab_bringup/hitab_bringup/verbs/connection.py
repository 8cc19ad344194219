"""A verb's connection to the swarm that is up."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hitab_client import console

if TYPE_CHECKING:
    from hitab_client import RosLink, RunFolder, RunRecord, SwarmClient, WorldClient
    from hitab_client.run_processes import RunProcesses


@dataclass
class Connection:
    """The agents, the world and the processes; also the run, if `hitab up` started the swarm."""

    link: RosLink
    agents: SwarmClient
    world: WorldClient
    processes: RunProcesses
    folder: RunFolder | None = None
    record: RunRecord | None = None

    @property
    def has_world(self) -> bool:
        """Whether `hitab up` has started a world."""
        return self.record is not None and self.record.world


@contextmanager
def connection(swarm: str | None = None) -> Iterator[Connection]:
    """Connect to the named swarm, or the one that is up, or any nodes in the ROS domain.

    Args:
        swarm: its name, identity or run folder.

    Raises:
        SwarmError: if none is up, or several are and none is named.
    """
    from hitab_client.domain_ids import chosen_by_user
    from hitab_client.swarm_choice import find_meant, look_elsewhere, none_is_up

    domain_id = chosen_by_user()
    found = find_meant(swarm, domain_id)
    if found is None:
        # Said before ROS is loaded, which takes a moment.
        console.note(none_is_up(domain_id))

    from hitab_client import RosLink, SwarmClient, WorldClient
    from hitab_client.run_processes import RunProcesses

    folder, record = found if found else (None, None)
    identity = record.identity if record else ""
    processes = RunProcesses(record)
    with RosLink(record.domain_id if record else domain_id or 0, console.note) as link:
        if found is None:
            look_elsewhere(link)
        agents = SwarmClient(
            link, record.agents if record else (), identity=identity, processes=processes
        )
        world = WorldClient(
            link,
            identity=identity,
            started_by_it=record.world if record else False,
            processes=processes,
        )
        yield Connection(link, agents, world, processes, folder, record)
