"""The link of an agent to its commander: orders in, reports out."""

from __future__ import annotations

from hitab_msgs import msg

from hitab_agent.node.agent_base import AgentBase
from hitab_core.orders import Order, Report, Subordinate


class SuperiorLink:
    """Obeys a commander's orders as they arrive, and reports to it.

    Attributes:
        subordinate: the agent as it obeys and reports.
        commander: name of the commander.
    """

    def __init__(self, node: AgentBase, subordinate: Subordinate) -> None:
        """Start to obey.

        Args:
            node: the agent's node.
            subordinate: the agent as it obeys and reports.
        """
        self.subordinate = subordinate
        self.commander = node.settings.commander
        self._ordered = node.ordered
        self._exchange = node.shared.exchange
        self._seconds = 0.0
        self._exchange.obey(node, self.commander, self._on_order)
        if node.has_robot:
            node.shared.signs.tell_of(subordinate)
        node.shared.signs.unless_told(node.guard.wrap("heartbeat", self._heartbeat))

    def _on_order(self, order: Order) -> None:
        with self._exchange.held():
            subordinate = self.subordinate
            if subordinate.take(order):
                self._ordered()
                self.tell()
            elif not (order.round or subordinate.round):  # repeated, since reports were lost
                self._send(subordinate.report())

    def settle(self) -> None:
        """Obey a waiting order, if the demonstrator is done, and report what has changed."""
        if self.subordinate.settle():
            self._ordered()
        self.tell()

    def obey_again(self) -> None:
        """Mark the last order as waiting, so that `settle` obeys it again."""
        subordinate = self.subordinate
        subordinate.waits = subordinate.ordered is not None

    def perceived(self, percept: msg.Percept, seconds: float, *, changed: bool = True) -> None:
        """Report the changes made by a percept and the tick after it.

        Args:
            percept: the percept.
            seconds: the agent's own time, s.
            changed: whether its activity may have changed since the previous percept.
        """
        subordinate = self.subordinate
        changed |= self._keep_time(percept, seconds)
        if subordinate.round:
            changed |= subordinate.rounds_end()
        if subordinate.refusal and subordinate.settle():
            self._ordered()  # the order may have been refused only for lack of a percept
            changed = True
        if percept.look or percept.back:
            # A person who arranges a paused world expects the commander to perceive the change.
            self._send(subordinate.report(back=percept.back))
        elif changed or subordinate.is_asked:
            self.tell()

    def round_begins(self, percept: msg.Percept, seconds: float) -> None:
        """Report the percept of a lockstep round, before the agent acts on it."""
        subordinate = self.subordinate
        self._keep_time(percept, seconds)
        if subordinate.refusal and subordinate.settle():
            self._ordered()
        self._send(
            subordinate.round_begins(
                percept.sequence, look=percept.look, restart=percept.restart, back=percept.back
            )
        )

    def _keep_time(self, percept: msg.Percept, seconds: float) -> bool:
        """Adopt a percept's time; return whether an episode has begun."""
        subordinate = self.subordinate
        subordinate.seconds = self._seconds = seconds
        if subordinate.episode == percept.episode and subordinate.seed == percept.seed:
            return False
        subordinate.episode, subordinate.seed = percept.episode, percept.seed
        return True

    def tell(self) -> None:
        """Report changes, if there are any."""
        self._send(self.subordinate.news(self._seconds))

    def _heartbeat(self) -> None:
        """Report percepts that changed nothing."""
        self._send(self.subordinate.heartbeat())

    def _send(self, report: Report | None) -> None:
        if report is not None:
            self._exchange.send(self.commander, report)
