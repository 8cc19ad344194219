"""The exchange of orders and reports between the agents and commanders of processes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import NamedTuple

from hitab_msgs import msg

from hitab_agent.links.exchange_topics import ExchangeTopics
from hitab_agent.scheduler import JobQueue, Scheduler
from hitab_core.orders import Order, Report
from hitab_ros import GuardedNode, HostRosters, names
from hitab_ros.timing import TURN_S

NEXT_S = 1e-6
"""Wait of what is handed over, s: only until the running callback has ended."""

TakeOrder = Callable[[Order], None]
Follow = Callable[[str, Order], None]
TakeReports = Callable[[Sequence[Report | msg.Report], str], None]
"""Receives reports and the name of the process that sent them, as in its signs of life."""
Lose = Callable[[Collection[str]], None]
"""Receives the names of subordinates whose process was started again."""


class _Commander(NamedTuple):
    members: frozenset[str]
    take: TakeReports
    lose: Lose


class Exchange:
    """Passes orders down to subordinates and reports up to commanders, for a whole process.

    Within the process, orders and reports are handed over as objects. As with a topic, each has
    a callback of its own, so nobody is called who is still at work. `ExchangeTopics` passes the
    others on to their processes.

    All agents of a host share an exchange, which delays reports briefly. So a commander gets one
    batch after an order has changed all its subordinates, and orders are passed down the
    hierarchy before their outcome is reported up.
    """

    def __init__(
        self, node: GuardedNode, scheduler: Scheduler, rosters: HostRosters | None = None
    ) -> None:
        """Create the exchange of a process.

        Args:
            node: the node of the only agent, or of a host, in its own namespace.
            scheduler: the process's scheduler.
            rosters: the rosters of all hosts; None if the process is no host.
        """
        self._node = node
        self._process = names.own_name(node)
        self._next = JobQueue(node, NEXT_S)
        self._later = JobQueue(node, TURN_S) if rosters is not None else None
        self._takers: dict[str, list[TakeOrder]] = {}
        self._followers: dict[str, list[Follow]] = {}
        self._last: dict[str, Order] = {}
        self._commanders: dict[str, _Commander] = {}
        self._superiors: dict[str, str] = {}
        self._waiting: dict[str, list[Report]] = {}
        self._held = False
        self._rosters = rosters
        self._topics = ExchangeTopics(node, self, self._next)
        if rosters is not None:
            self._topics.join_hosts(scheduler, rosters)

    # -- orders -----------------------------------------------------------------------------

    def obey(self, node: GuardedNode, commander: str, take: TakeOrder) -> None:
        """Call ``take`` with the order in force, if there is one, and with each new order.

        Args:
            node: the subordinate's node, whose status shows a failure of ``take``.
            commander: name of the commander.
            take: receives the orders.
        """
        take = node.guard.wrap(f"order of {commander}", take)
        if commander not in self._takers:
            self._takers[commander] = []
            self._topics.seek(commander)
        self._takers[commander].append(take)
        if commander in self._last:
            take(self._last[commander])

    def follow(self, commander: str, follow: Follow) -> None:
        """Call ``follow`` with the last order, and each new one after all subordinates have it."""
        follow = self._node.guard.wrap(f"round of {commander}", follow)
        self._followers.setdefault(commander, []).append(follow)
        if commander in self._last:
            follow(commander, self._last[commander])

    def give(self, commander: str, order: Order) -> None:
        """Pass on the order of a commander of this process."""
        if commander in self._takers:
            self._next.call(partial(self.deliver, commander, order))
        self._topics.give(commander, order, self._commanders[commander].members)

    def deliver(self, commander: str, order: Order) -> None:
        """Hand an order over to the subordinates in this process."""
        if takers := self._takers.get(commander):
            self._last[commander] = order
            for take in takers:
                take(order)
            for follow in self._followers.get(commander, ()):
                follow(commander, order)

    # -- reports ----------------------------------------------------------------------------

    def command(
        self, node: GuardedNode, members: Collection[str], take: TakeReports, lose: Lose
    ) -> None:
        """Make a commander of this process known.

        Args:
            node: its node.
            members: names of its subordinates.
            take: receives their reports.
            lose: called when subordinates may have lost the order, since they were restarted.
        """
        name, wrap = names.own_name(node), node.guard.wrap
        self._commanders[name] = _Commander(
            frozenset(members), wrap("reports", take), wrap("restarted subordinates", lose)
        )
        self._superiors.update(dict.fromkeys(members, name))

    @property
    def subordinates(self) -> Collection[str]:
        """The subordinates of the commanders of this process."""
        return self._superiors.keys()

    @property
    def superiors(self) -> Collection[str]:
        """The commanders of the agents of this process."""
        return self._takers.keys()

    def is_here(self, commander: str) -> bool:
        """Whether this process has a commander."""
        return commander in self._commanders

    def send(self, commander: str, report: Report) -> None:
        """Send a report: at once, after the host's delay, or when the exchange is released."""
        if self._later is not None and not self._waiting:
            self._later.call(self._flush)
        self._waiting.setdefault(commander, []).append(report)
        if self._later is None and not self._held:
            self._flush()

    @contextmanager
    def held(self) -> Iterator[None]:
        """Collect reports during the block; send them at its end."""
        if self._held:
            yield
            return
        self._held = True
        try:
            yield
        finally:
            self._held = False
            if self._later is None:
                self._flush()

    @contextmanager
    def at_once(self) -> Iterator[None]:
        """Collect reports during the block; send them at its end, without further delay."""
        with self.held():
            yield
        self._flush()

    def _flush(self) -> None:
        waiting, self._waiting = self._waiting, {}
        for commander in filter(self.is_here, waiting):
            take = self._commanders[commander].take
            self._next.call(partial(take, waiting[commander], self._process))
        self._topics.send(waiting)

    def sort(self, reports: Sequence[msg.Report], process: str) -> None:
        """Hand reports of another host over to the commanders of their agents."""
        found: dict[str, list[msg.Report]] = {}
        for report in self.believed(reports, process):
            if (commander := self._superiors.get(report.agent)) is not None:
                found.setdefault(commander, []).append(report)
        for commander, theirs in found.items():
            self._commanders[commander].take(theirs, process)

    def believed(self, reports: Sequence[msg.Report], process: str) -> Sequence[msg.Report]:
        """Return the reports of a process without those of agents that another host holds."""
        if self._rosters is None:
            return reports
        return [one for one in reports if self._rosters.believes(process, one.agent)]

    def restarted(self, agents: Collection[str]) -> None:
        """Make the commanders of agents know that these were restarted."""
        for commander in self._commanders.values():
            if lost := commander.members.intersection(agents):
                commander.lose(lost)
