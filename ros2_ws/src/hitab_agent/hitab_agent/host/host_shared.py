"""What the agents of a host share."""

from __future__ import annotations

from hitab_agent.deferred import Deferred
from hitab_agent.host.host_link import HostLink
from hitab_agent.report_outbox import ReportOutbox
from hitab_agent.shared import Shared
from hitab_ros import GuardedNode, names

REPORTS_PERIOD_S = 0.01
"""How long a report waits for others of the same host."""


def shared_on_host(node: GuardedNode, agents: int, swarm: str = "") -> Shared:
    """Return what the agents of a host share.

    Args:
        node: of the host, in its own namespace.
        agents: number of agents.
        swarm: identity of their swarm; empty: none.
    """

    def link_to(world: str) -> HostLink:
        name = names.own_name(node)
        return HostLink(node, name, world, shared.outbox, shared.orders, swarm)

    shared = Shared.on(node)
    shared.host = node
    shared.link_to = link_to
    node.guard.faults.changed = shared.tell_all
    shared.outbox = ReportOutbox(node, Deferred(node, REPORTS_PERIOD_S))
    shared.offer_on_demand(node, agents)
    return shared
