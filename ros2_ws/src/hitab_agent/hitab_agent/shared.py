"""What the agents of one process share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from hitab_agent.deferred import Deferred
from hitab_agent.distribution import DistributionReceiver
from hitab_agent.order_subscriptions import OrderSubscriptions
from hitab_agent.report_outbox import ReportOutbox
from hitab_agent.services_on_demand import (
    LOOK_AT_PER_S,
    LOOK_PERIOD_S,
    ServicesOnDemand,
)
from hitab_agent.shared_link import SharedLink
from hitab_agent.ticker import Ticker
from hitab_core import BehaviorLibrary, Domain, load_domain
from hitab_core.library import Editions
from hitab_ros import GuardedNode
from hitab_ros.diagnostics import Diagnosis, Diagnostics

STATUS_PERIOD_S = 0.05
"""The path of active states may change every cycle; it is published at most this often."""

STATUSES_AT_ONCE = 15
"""A host publishes at most this many statuses in a period, 300 a second: watching must not cost
more than what is watched."""


@dataclass(slots=True)
class Shared:
    """Timers, publishers and whatever else a process needs once, however many agents it runs.

    Attributes:
        ticker: calls at fixed rates.
        statuses: publishes changed statuses a little later.
        orders: receives the orders of commanders.
        outbox: sends reports to commanders.
        distributions: sends and receives behaviors.
        host: the node of the host, if the process is one.
        link_to: creates the link of all agents to a world; None: each agent has its own.
        links: the links it created, by the world's name.
        on_demand: offers services when a client asks; None: each agent offers its own at once.
        domains: the loaded domains, by name and what was taken out.
        libraries: the open libraries, by folder and domain.
        members: of a host, called when the faults of the host change.
        editions: read and cache the contents of libraries, by domain.
        told: faults of libraries that are in the log.
        diagnosed: return the diagnoses of the agents.
        diagnostics: publishes them.
    """

    ticker: Ticker
    statuses: Deferred
    orders: OrderSubscriptions
    outbox: ReportOutbox
    distributions: DistributionReceiver
    diagnostics: Diagnostics
    diagnosed: list[Callable[[], Diagnosis]]
    host: GuardedNode | None = None
    link_to: Callable[[str], SharedLink] | None = None
    links: dict[str, SharedLink] = field(default_factory=dict)
    on_demand: ServicesOnDemand | None = None
    domains: dict[str, Domain] = field(default_factory=dict)
    libraries: dict[tuple[Path, int], BehaviorLibrary] = field(default_factory=dict)
    editions: dict[int, Editions] = field(default_factory=dict)
    members: list[Callable[[], None]] = field(default_factory=list)
    told: set[str] = field(default_factory=set)

    @classmethod
    def on(cls, node: GuardedNode) -> Shared:
        """Return what a node needs for itself, or for the agents of its process."""
        diagnosed: list[Callable[[], Diagnosis]] = []
        return cls(
            Ticker(node),
            Deferred(node, STATUS_PERIOD_S, STATUSES_AT_ONCE),
            OrderSubscriptions(node),
            ReportOutbox(node),
            DistributionReceiver(node),
            Diagnostics(node, lambda: [diagnose() for diagnose in diagnosed]),
            diagnosed,
        )

    def offer_on_demand(self, node: GuardedNode, agents: int) -> None:
        """Have the agents, so many in number, create their services when a client asks."""
        if self.on_demand is None:
            self.on_demand = ServicesOnDemand(node)
            self.ticker.every(max(LOOK_PERIOD_S, agents / LOOK_AT_PER_S), self.on_demand.look)

    def tell_all(self) -> None:
        """Have all agents show the current faults of their host."""
        for member in self.members:
            member()

    @property
    def faults(self) -> list[str]:
        """The faults of the host, and so of each of its agents."""
        return [] if self.host is None else self.host.guard.faults.texts()

    def link(self, world: str) -> SharedLink | None:
        """Return the link of all agents to a world; None if each has its own."""
        if self.link_to is not None and world not in self.links:
            self.links[world] = self.link_to(world)
        return self.links.get(world)

    def library(self, folder: Path, domain: Domain) -> BehaviorLibrary:
        """Return the library in a folder; agents with the same folder share it.

        Libraries with the same files share what was read from them.
        """
        key = (folder, id(domain))  # the library found under it keeps the domain alive
        if key not in self.libraries:
            editions = self.editions.setdefault(id(domain), Editions(domain))
            self.libraries[key] = BehaviorLibrary(folder, domain, editions=editions)
        return self.libraries[key]

    def domain(self, name: str, without: Sequence[str] = ()) -> Domain:
        """Return the installed domain with a name; see `load_domain`.

        Args:
            name: of the domain.
            without: hand-written automata to take out; see `Domain.without`.

        Raises:
            HitabError: if there is none, or it has no such hand-written automata.
        """
        if name not in self.domains:
            self.domains[name] = load_domain(name)
        if not without:
            return self.domains[name]
        rest = f"{name} without {', '.join(sorted(without))}"
        if rest not in self.domains:
            self.domains[rest] = self.domains[name].without(without)
        return self.domains[rest]
