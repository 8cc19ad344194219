"""Resources shared by the agents of one process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from hitab_agent.agent_services import CommandsToMany, offer_loading
from hitab_agent.endpoints_on_demand import EndpointsOnDemand
from hitab_agent.host.roster_topic import RosterTopic
from hitab_agent.host.status_batches import StatusBatches
from hitab_agent.links.order_exchange import Exchange
from hitab_agent.links.reach_watch import ReachWatch
from hitab_agent.node.agent_base import AgentBase
from hitab_agent.process_signs import ProcessSigns
from hitab_agent.scheduler import JobQueue, Scheduler
from hitab_agent.topics.decision_watch import DecisionWatch
from hitab_agent.topics.distribution import Distributions
from hitab_agent.topics.preview_watch import PreviewWatch
from hitab_core import BehaviorLibrary, Domain, load_domain
from hitab_core.library import LibraryReader
from hitab_ros import GuardedNode, HostRosters, Lease, names
from hitab_ros.leases import NO_LEASE
from hitab_ros.nodes.diagnostics import Diagnostics
from hitab_ros.timing import AT_ONCE_S

if TYPE_CHECKING:
    from hitab_agent.host.host_link import HostLink

STATUSES_AT_ONCE = 15
"""A host publishes at most this many statuses in a period, 300 a second, so that being watched
costs less than running."""


class HostResources:
    """Timers, publishers and links that a process needs once, however many agents it runs.

    Attributes:
        name: name of the process in its signs of life.
        nodes: the nodes of the agents that have joined.
        host: the node of the host, if the process is one.
        scheduler: calls at fixed rates.
        statuses: publishes changed statuses a little later.
        exchange: passes orders down and reports up.
        signs: completes the process's signs of life, and passes on those of subordinates.
        reach: watches who is in reach of agents that halt otherwise.
        distributions: sends and receives behaviors.
        decisions: notices decisions that are far from all examples.
        diagnostics: publishes the agents' faults.
        on_demand: opens the agents' endpoints for those who ask; None if all are open.
        batches: publishes a host's statuses; None if the process is no host.
        roster: publishes a host's roster; None if the process is no host.
        rosters: the rosters of all hosts; None if the process is no host.
        links: the links of a host's agents to their worlds, by the world's name.
        domains: the loaded domains, by name.
        logged: faults of libraries that are in the log.
    """

    def __init__(
        self,
        node: GuardedNode,
        *,
        is_host: bool = False,
        on_demand: bool = False,
        swarm: str = "",
        lease: Lease = NO_LEASE,
        give_up: Callable[[str], None] = lambda reason: None,
    ) -> None:
        """Create the resources.

        Args:
            node: the node of the only agent, or of a host, in its own namespace.
            is_host: whether the process is a host.
            on_demand: whether endpoints are opened for those who ask, instead of all at once.
            swarm: identity of the agents' swarm; empty if none.
            lease: a host's lease of its agents.
            give_up: called with the reason if a host yields; ends the process at once.
        """
        self.name = names.own_name(node)
        self.nodes: list[AgentBase] = []
        self.host = node if is_host else None
        self.scheduler = Scheduler(node)
        self.statuses = JobQueue(node, AT_ONCE_S, STATUSES_AT_ONCE)
        self.rosters = rosters = (
            HostRosters(
                node,
                names.in_swarm(node, names.HOSTS),
                lambda roster: swarm in ("", roster.swarm),
                leases=bool(lease.number),
            )
            if is_host
            else None
        )
        self.exchange = Exchange(node, self.scheduler, rosters)
        self.signs = ProcessSigns(node)
        self.reach = ReachWatch(node, self, rosters)
        self.distributions = Distributions(node, self.nodes)
        self.decisions = DecisionWatch(self.nodes, self.scheduler)
        self.previews = PreviewWatch(self.nodes, self.scheduler)
        self.diagnostics = Diagnostics(node, lambda: [one.diagnose() for one in self.nodes])
        self.on_demand = (
            EndpointsOnDemand(node, self.scheduler, topics=is_host) if on_demand else None
        )
        self.links: dict[str, HostLink] = {}
        self.domains: dict[str, Domain] = {}
        self.logged: set[str] = set()
        self.roster: RosterTopic | None = None
        self.batches: StatusBatches | None = None
        self._libraries: dict[tuple[Path, int], BehaviorLibrary] = {}
        self._readers: dict[int, LibraryReader] = {}
        if rosters is not None:
            self.roster = RosterTopic(
                node, self.nodes, swarm, rosters, self.scheduler, lease, give_up
            )
            self.batches = StatusBatches(node, self.nodes, self.scheduler)
            CommandsToMany(node, self.nodes)
            offer_loading(node, self.nodes)
            node.guard.faults.changed = self._publish_all_soon

    def _publish_all_soon(self) -> None:
        """Make all agents publish the current faults of their host."""
        for node in self.nodes:
            node.status.publish_soon()

    @property
    def faults(self) -> list[str]:
        """The faults of the host, which each of its agents shows too."""
        return [] if self.host is None else self.host.guard.faults.texts()

    def publish_roster(self) -> None:
        """Tell the world and other hosts which agents this host runs."""
        assert self.roster is not None, "only hosts have one"
        self.roster.remember(Path(self.nodes[0].settings.state_dir).expanduser())
        self.roster.publish()

    def link(self, host: GuardedNode, world: str) -> HostLink:
        """Return the link of all agents of a host to a world."""
        if world not in self.links:
            from hitab_agent.host.host_link import HostLink  # only hosts need this import

            assert self.roster is not None, "only hosts have such links"
            self.links[world] = HostLink(
                host, self.name, world, self.exchange, self.nodes, self.roster
            )
        return self.links[world]

    def library(self, folder: Path, domain: Domain) -> BehaviorLibrary:
        """Return the library in a folder; agents with the same folder share it.

        Libraries with equal files share the loaded behaviors.
        """
        key = (folder, id(domain))  # unique, since the stored library keeps the domain alive
        if key not in self._libraries:
            reader = self._readers.setdefault(id(domain), LibraryReader(domain))
            self._libraries[key] = BehaviorLibrary(folder, domain, reader=reader)
        return self._libraries[key]

    def domain(self, name: str) -> Domain:
        """Return the installed domain with a name; see `load_domain`.

        Raises:
            HitabError: if there is none.
        """
        if name not in self.domains:
            self.domains[name] = load_domain(name)
        return self.domains[name]
