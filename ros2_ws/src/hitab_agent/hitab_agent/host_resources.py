"""Resources that the agents of one process share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from hitab_agent.agent_base import AgentBase
from hitab_agent.distribution import Distributions
from hitab_agent.order_subscriptions import OrderSubscriptions
from hitab_agent.report_outbox import ReportOutbox
from hitab_agent.scheduler import JobQueue, Scheduler
from hitab_agent.services_on_demand import ServicesOnDemand
from hitab_core import BehaviorLibrary, Domain, load_domain
from hitab_core.library import LibraryReader
from hitab_ros import GuardedNode, names
from hitab_ros.diagnostics import Diagnostics

if TYPE_CHECKING:
    from hitab_agent.host.host_link import HostLink

STATUS_PERIOD_S = 0.05
"""The path of active states may change every cycle; it is published at most this often."""

STATUSES_AT_ONCE = 15
"""A host publishes at most this many statuses in a period, 300 a second: watching must not cost
more than what is watched."""

REPORTS_PERIOD_S = 0.01
"""How long a report waits for others of the same host."""


class HostResources:
    """Timers, publishers and links that a process needs once, however many agents it runs.

    Attributes:
        nodes: of the agents that have joined.
        host: the node of the host, if the process is one.
        scheduler: calls at fixed rates.
        statuses: publishes changed statuses a little later.
        orders: receives the orders of commanders.
        outbox: sends reports to commanders.
        distributions: sends and receives behaviors.
        diagnostics: publishes what is wrong with the agents.
        on_demand: offers services when a client asks; None if each agent offers its own at once.
        links: of all agents of a host to their worlds, by the world's name.
        domains: the loaded domains, by name.
        told: faults of libraries that are in the log.
    """

    def __init__(self, node: GuardedNode, agents: int = 0, swarm: str = "") -> None:
        """Make the resources.

        Args:
            node: of the only agent, or of a host, in its own namespace.
            agents: number of agents of a host; 0 if the process is none.
            swarm: identity of their swarm; empty if none.
        """
        self.nodes: list[AgentBase] = []
        self.host = node if agents else None
        self.scheduler = Scheduler(node)
        self.statuses = JobQueue(node, STATUS_PERIOD_S, STATUSES_AT_ONCE)
        self.orders = OrderSubscriptions(node)
        self.outbox = ReportOutbox(node, JobQueue(node, REPORTS_PERIOD_S) if agents else None)
        self.distributions = Distributions(node, self.nodes)
        self.diagnostics = Diagnostics(node, lambda: [one.diagnose() for one in self.nodes])
        self.on_demand: ServicesOnDemand | None = None
        self.links: dict[str, HostLink] = {}
        self.domains: dict[str, Domain] = {}
        self.told: set[str] = set()
        self._swarm = swarm
        self._libraries: dict[tuple[Path, int], BehaviorLibrary] = {}
        self._editions: dict[int, LibraryReader] = {}
        if agents:
            node.guard.faults.changed = self._tell_all
            self.offer_on_demand(node, agents)

    def offer_on_demand(self, node: GuardedNode, agents: int = 1) -> None:
        """Have the agents, so many in number, create their services when a client asks."""
        if self.on_demand is None:
            self.on_demand = ServicesOnDemand(node, self.scheduler, agents)

    def _tell_all(self) -> None:
        """Have all agents show the current faults of their host."""
        for node in self.nodes:
            node.status.publish_soon()

    @property
    def faults(self) -> list[str]:
        """The faults of the host, and so of each of its agents."""
        return [] if self.host is None else self.host.guard.faults.texts()

    def link(self, host: GuardedNode, world: str) -> HostLink:
        """Return the link of all agents of a host to a world."""
        if world not in self.links:
            from hitab_agent.host.host_link import HostLink  # an agent alone does not need it

            name = names.own_name(host)
            self.links[world] = HostLink(host, name, world, self.outbox, self.orders, self._swarm)
        return self.links[world]

    def library(self, folder: Path, domain: Domain) -> BehaviorLibrary:
        """Return the library in a folder; agents with the same folder share it.

        Libraries with the same files share what was read from them.
        """
        key = (folder, id(domain))  # the library found under it keeps the domain alive
        if key not in self._libraries:
            editions = self._editions.setdefault(id(domain), LibraryReader(domain))
            self._libraries[key] = BehaviorLibrary(folder, domain, reader=editions)
        return self._libraries[key]

    def domain(self, name: str) -> Domain:
        """Return the installed domain with a name; see `load_domain`.

        Raises:
            HitabError: if there is none.
        """
        if name not in self.domains:
            self.domains[name] = load_domain(name)
        return self.domains[name]
