"""What the agents of one process have in common."""

from __future__ import annotations

from dataclasses import dataclass, field

from rclpy.node import Node

from hitab_agent.distribution import DistributionDesk
from hitab_agent.host_link import HostLink
from hitab_agent.later import Later
from hitab_agent.report_outbox import ReportOutbox
from hitab_agent.services_on_demand import ServicesOnDemand
from hitab_agent.ticker import Ticker
from hitab_core.domain import Domain, load_domain

STATUS_PERIOD_S = 0.05
"""The path of active states may change every cycle; it is published no more often than this."""


@dataclass(slots=True)
class Shared:
    """Timers, publishers and whatever else one process needs once, however many agents it runs.

    Attributes:
        ticker: calls at fixed rates.
        statuses: publishes, a little later, the statuses that have changed.
        outbox: sends reports to commanders.
        distributions: sends and receives behaviors.
        link: to the world, where it is shared; None: each agent has its own.
        on_demand: offers services when somebody asks; None: each agent offers its own at once.
        domains: the domains that were loaded, by name.
    """

    ticker: Ticker
    statuses: Later
    outbox: ReportOutbox
    distributions: DistributionDesk
    link: HostLink | None = None
    on_demand: ServicesOnDemand | None = None
    domains: dict[str, Domain] = field(default_factory=dict)

    @classmethod
    def on(cls, node: Node) -> Shared:
        """Return what a node needs for itself, or a host's for the agents of its process."""
        return cls(
            Ticker(node), Later(node, STATUS_PERIOD_S), ReportOutbox(node), DistributionDesk(node)
        )

    def domain(self, name: str) -> Domain:
        """Return the installed domain of a name; see `load_domain`.

        Raises:
            HitabError: if there is none.
        """
        if name not in self.domains:
            self.domains[name] = load_domain(name)
        return self.domains[name]
