"""The topics on which processes exchange orders and reports."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, Protocol

from hitab_msgs import msg

from hitab_agent.scheduler import JobQueue, Scheduler
from hitab_core.codec import from_dict
from hitab_core.orders import Order, Report
from hitab_ros import GuardedNode, HostRosters, names, qos
from hitab_ros.messages.conversions import message_of
from hitab_ros.timing import POLL_S


class Ends(Protocol):
    """The agents and commanders of this process, as `hitab_agent.links.exchange` has them."""

    @property
    def subordinates(self) -> Collection[str]:
        """The subordinates of the commanders."""

    @property
    def superiors(self) -> Collection[str]:
        """The commanders of the agents."""

    def is_here(self, commander: str) -> bool:
        """Whether this process has a commander."""

    def deliver(self, commander: str, order: Order) -> None:
        """Hand an order over to the subordinates."""

    def sort(self, reports: Sequence[msg.Report], process: str) -> None:
        """Hand reports of a process over to the commanders."""

    def restarted(self, agents: Collection[str]) -> None:
        """Make the commanders of agents know that these were restarted."""


class ExchangeTopics:
    """Sends orders and reports to other processes, and receives theirs.

    A host sends to another host on that host's topics, for all its agents and commanders. Their
    rosters tell who lives there. To and from a process of its own, a commander's topics are used.

    What is sent before its receiver is connected is lost, and not missed: a commander repeats its
    order until each subordinate has reported that it knows the order.
    """

    def __init__(self, node: GuardedNode, ends: Ends, soon: JobQueue) -> None:
        """Create no endpoints yet.

        Args:
            node: the node of the only agent, or of a host, in its own namespace.
            ends: the agents and commanders of the process.
            soon: calls what collects orders.
        """
        self._node = node
        self._ends = ends
        self._soon = soon
        self._process = names.own_name(node)
        self._host_of: Mapping[str, str] = {}
        self._is_host = False
        self._sought: set[str] = set()
        self._hosts: set[str] = set()  # other hosts
        self._publishers: dict[str, Any] = {}
        self._orders: dict[str, dict[str, Order]] = {}  # by host and commander

    def join_hosts(self, scheduler: Scheduler, rosters: HostRosters) -> None:
        """Listen to other hosts."""
        create = self._node.create_subscription
        self._is_host = True
        self._host_of = rosters.host_of
        rosters.changed.append(self._on_roster)
        create(msg.Orders, self._topic(self._process, names.ORDERS), self._on_orders, qos.EVENTS)
        create(
            msg.Reports, self._topic(self._process, names.REPORTS), self._on_reports, qos.EVENTS
        )
        scheduler.every(POLL_S, self._look)

    def _topic(self, receiver: str, name: str) -> str:
        return names.in_swarm(self._node, receiver, name)

    def _publisher(self, kind: Any, topic: str) -> Any:
        if topic not in self._publishers:
            self._publishers[topic] = self._node.create_publisher(kind, topic, qos.EVENTS)
        return self._publishers[topic]

    # -- commanders in processes of their own -----------------------------------------------

    def seek(self, commander: str) -> None:
        """Connect to a commander's topics; as a host, once they are there and no host has it."""
        if self._is_host:
            self._sought.add(commander)
        else:
            self._connect(commander)

    def _look(self) -> None:
        """Look for the topics of commanders that are in no host."""
        self._sought -= {*filter(self._ends.is_here, self._sought)}
        for commander in self._sought - self._host_of.keys():
            if self._node.count_publishers(self._topic(commander, names.ORDER)):
                self._sought.remove(commander)
                self._connect(commander)

    def _connect(self, commander: str) -> None:
        self._publisher(msg.Reports, self._topic(commander, names.REPORTS))
        self._node.create_subscription(
            msg.Order,
            self._topic(commander, names.ORDER),
            lambda order: self._take(commander, order),
            qos.LATCHED,
        )

    # -- orders -----------------------------------------------------------------------------

    def give(self, commander: str, order: Order, members: Collection[str]) -> None:
        """Send an order to all other hosts in which subordinates live."""
        hosts = {self._host_of.get(name, self._process) for name in members} - {self._process}
        if hosts and not self._orders:
            self._soon.call(self._send_orders)
        for host in hosts:
            self._orders.setdefault(host, {})[commander] = order

    def _send_orders(self) -> None:
        waiting, self._orders = self._orders, {}
        for host, orders in waiting.items():
            batch = [
                message_of(msg.Order, order, commander=commander, order=order.name)
                for commander, order in orders.items()
            ]
            publisher = self._publisher(msg.Orders, self._topic(host, names.ORDERS))
            publisher.publish(msg.Orders(orders=batch))

    def _on_orders(self, message: msg.Orders) -> None:
        for order in message.orders:
            self._take(order.commander, order)

    def _take(self, commander: str, order: msg.Order) -> None:
        self._ends.deliver(commander, from_dict(Order, order, name=order.order))

    # -- reports ----------------------------------------------------------------------------

    def send(self, waiting: Mapping[str, Sequence[Report]]) -> None:
        """Send the reports to commanders in other processes, in one message to each process."""
        batches: dict[str, list[Report]] = {}
        for commander, reports in waiting.items():
            if self._ends.is_here(commander):
                continue
            topic = self._topic(self._host_of.get(commander, commander), names.REPORTS)
            if commander in self._host_of or topic in self._publishers:
                batches.setdefault(topic, []).extend(reports)
        for topic, batch in batches.items():
            self._node.guard.run(f"reports on {topic}", self._send_reports, topic, batch)

    def _send_reports(self, topic: str, batch: Sequence[Report]) -> None:
        reports = [message_of(msg.Report, report) for report in batch]
        publisher = self._publisher(msg.Reports, topic)
        publisher.publish(msg.Reports(process=self._process, reports=reports))

    def _on_reports(self, message: msg.Reports) -> None:
        self._ends.sort(message.reports, message.process)

    def _on_roster(self, roster: msg.HostRoster) -> None:
        # Connecting takes time, and in lockstep the first order is already waited for.
        for kind, name, others in (
            (msg.Orders, names.ORDERS, self._ends.subordinates),
            (msg.Reports, names.REPORTS, self._ends.superiors),
        ):
            for host in {self._host_of.get(other, self._process) for other in others}:
                if host != self._process:
                    self._publisher(kind, self._topic(host, name))
        if roster.host in self._hosts:
            self._ends.restarted(roster.agents)
        elif roster.host != self._process:
            self._hosts.add(roster.host)
