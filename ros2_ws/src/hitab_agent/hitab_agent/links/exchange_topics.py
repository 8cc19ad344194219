"""The topics on which processes exchange orders and reports."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, Protocol

from hitab_msgs import msg

from hitab_agent.scheduler import JobQueue, Scheduler
from hitab_core.codec import from_dict
from hitab_core.orders import Order, Report
from hitab_ros import GuardedNode, HostRosters, names, qos
from hitab_ros.messages.conversions import message_of
from hitab_ros.timing import POLL_S


class Ends(Protocol):
    """The agents and commanders of this process; see `hitab_agent.links.order_exchange`."""

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
    rosters tell who lives there, and only hosts that listen are believed. To and from a process
    of its own, a commander's topics are used.

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
        self._hosts_of: Mapping[str, tuple[str, ...]] = {}
        self._is_host = self._leases = False
        self._sought: set[str] = set()
        self._hosted: set[str] = set()  # the agents that were in other hosts
        self._unconnected: set[tuple[Any, str]] = set()  # types and topics of other hosts
        self._publishers: dict[str, Any] = {}
        self._orders: dict[str, dict[str, Order]] = {}  # by host and commander

    def join_hosts(self, scheduler: Scheduler, rosters: HostRosters) -> None:
        """Listen to other hosts."""
        create = self._node.create_subscription
        self._is_host = True
        self._hosts_of, self._leases = rosters.hosts_of, rosters.leases
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
        """Connect to a commander's topics; as a host, once they are there and no host has it.

        Where leases count, all commanders are in hosts.
        """
        if not self._is_host:
            self._connect(commander)
        elif not self._leases:
            self._sought.add(commander)

    def _look(self) -> None:
        """Look for the topics of hosts, and of commanders that are in none."""
        self._connect_to_hosts()
        self._sought -= {*filter(self._ends.is_here, self._sought)}
        for commander in [*self._sought]:
            hosts = self._others_of([commander])
            if any(self._listens(self._topic(host, names.REPORTS)) for host in hosts):
                continue
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

    def _others_of(self, members: Iterable[str]) -> set[str]:
        """Return the other hosts that list one of these agents or commanders."""
        return {h for name in members for h in self._hosts_of.get(name, ())} - {self._process}

    def _listens(self, topic: str) -> bool:
        return self._node.count_subscribers(topic) > 0

    def _connect_to_hosts(self) -> None:
        for kind, topic in [*self._unconnected]:
            if self._listens(topic):
                self._unconnected.remove((kind, topic))
                self._publisher(kind, topic)

    # -- orders -----------------------------------------------------------------------------

    def give(self, commander: str, order: Order, members: Collection[str]) -> None:
        """Send an order to all other hosts in which subordinates live."""
        topics = {h: self._topic(h, names.ORDERS) for h in self._others_of(members)}
        hosts = [host for host, topic in topics.items() if topic in self._publishers]
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
            self._publishers[self._topic(host, names.ORDERS)].publish(msg.Orders(orders=batch))

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
            for receiver in {commander, *self._others_of([commander])}:
                topic = self._topic(receiver, names.REPORTS)
                if topic in self._publishers:
                    batches.setdefault(topic, []).extend(reports)
        for topic, batch in batches.items():
            self._node.guard.run(f"reports on {topic}", self._send_reports, topic, batch)

    def _send_reports(self, topic: str, batch: Sequence[Report]) -> None:
        reports = [message_of(msg.Report, report) for report in batch]
        self._publishers[topic].publish(msg.Reports(process=self._process, reports=reports))

    def _on_reports(self, message: msg.Reports) -> None:
        self._ends.sort(message.reports, message.process)

    def _on_roster(self, roster: msg.HostRoster) -> None:
        # Connecting takes time, and in lockstep the first order is already waited for.
        self._unconnected = {
            (kind, topic)
            for kind, name, others in (
                (msg.Orders, names.ORDERS, self._ends.subordinates),
                (msg.Reports, names.REPORTS, self._ends.superiors),
            )
            for host in self._others_of(others)
            if (topic := self._topic(host, name)) not in self._publishers
        }
        self._connect_to_hosts()
        if roster.host != self._process:
            if again := self._hosted.intersection(roster.agents):
                self._ends.restarted(again)
            self._hosted.update(roster.agents)
