"""Connection of a verb to the swarm that is up."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NoReturn

from hitab_client import console
from hitab_client.terminal.cli_remedies import with_commands
from hitab_ros.timing import REFRESH_S

if TYPE_CHECKING:
    from hitab_client import RosLink, RunFolder, RunRecord, SwarmClient, WorldClient
    from hitab_client.runs.run_processes import RunProcesses
    from hitab_machines import SwarmMachines


@dataclass
class Connection:
    """The agents, the world and the processes; also the run, if `hitab up` started the swarm.

    Attributes:
        machines: the machines of the swarm, if it runs on several.
    """

    link: RosLink
    agents: SwarmClient
    world: WorldClient
    processes: RunProcesses
    folder: RunFolder | None = None
    record: RunRecord | None = None
    machines: SwarmMachines | None = None

    def need_machines(self) -> SwarmMachines:
        """Return the machines of the swarm.

        Raises:
            SwarmError: if it runs on one, or was not started from here.
        """
        from hitab_client import SwarmError

        if self.machines is None:
            raise SwarmError(
                "this swarm has no machines that are known here; name them under `machines:` in "
                "its file, and ask on one of them"
            )
        return self.machines

    def note_whose(self, identities: Iterable[str]) -> None:
        """Print which swarms have answered that were not started from here.

        Args:
            identities: identities in the statuses of nodes that have answered.
        """
        from hitab_client.runs.swarm_choice import whose

        if self.record is None and not self.agents.identity:
            for sentence in whose(identities):
                console.note(sentence)

    def await_world(self) -> WorldClient | None:
        """Return the world, once it answers; None without a world.

        Raises:
            SwarmError: if the swarm's world does not answer.
        """
        if not (self.has_world or self.world.is_there()):
            return None
        self.world.wait()
        return self.world

    def watch(self, shown: Callable[[], list[Any]]) -> NoReturn:
        """Show something and keep it up to date, until Ctrl-C."""
        from rich.console import Group

        with console.live(Group(*shown())) as update:
            while True:
                self.link.spin_until(lambda: False, REFRESH_S)
                update(Group(*shown()))

    @property
    def has_world(self) -> bool:
        """Whether `hitab up` has started a world."""
        return self.record is not None and self.record.world


@contextmanager
def connection(swarm: str | None = None, *, reads: bool = False) -> Iterator[Connection]:
    """Connect to the named swarm, or the one that is up, or nodes that were started by hand.

    A swarm that was started elsewhere (another HITAB_HOME, user or computer) is chosen only if its
    identity is given, or if the verb only reads.

    Args:
        swarm: name, identity, namespace or run folder.
        reads: whether the verb changes nothing; it has to call `Connection.note_whose`.

    Raises:
        SwarmError: if no swarm is up, or several are up and none is named.
    """
    from hitab_client.connecting.domain_ids import chosen_by_user
    from hitab_client.runs.swarm_choice import find_meant, is_namespace, look_elsewhere, none_is_up

    domain_id = chosen_by_user()
    found = find_meant(swarm, domain_id)
    if found is None:
        # Printed before ROS is loaded, which takes a moment.
        console.note(with_commands(*none_is_up(domain_id)))

    from hitab_client import RosLink, SwarmClient, WorldClient
    from hitab_client.connecting.identity import STARTED_BY_HAND
    from hitab_client.runs.run_processes import RunProcesses

    folder, record = found if found else (None, None)
    namespace = swarm if swarm and is_namespace(swarm) else ""
    named = record.identity if record else swarm if not namespace else None
    identity = named or ("" if reads else STARTED_BY_HAND)
    processes = RunProcesses(record)
    with RosLink(record.domain_id if record else domain_id or 0, console.note) as link:
        prefix = record.namespace if record else look_elsewhere(link, namespace, identity)
        of_it: dict[str, Any] = {"prefix": prefix, "identity": identity, "processes": processes}
        agents = SwarmClient(link, record.agents if record else (), **of_it)
        world = WorldClient(link, started_by_it=record is not None and record.world, **of_it)
        machines = None
        if record is not None and record.machines:
            from hitab_machines import SwarmMachines

            machines = SwarmMachines(link, record)
        yield Connection(link, agents, world, processes, folder, record, machines)
