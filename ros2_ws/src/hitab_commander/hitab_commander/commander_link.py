"""The link of a commander to its group: reports in, orders out."""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from dataclasses import replace

from hitab_msgs import msg

from hitab_agent import AgentNode, HeardTopic, PublishedTopic, RoundGate
from hitab_commander.commander_body import CommanderBody
from hitab_commander.group_settings import GroupSettings
from hitab_commander.group_status import GroupStatus
from hitab_commander.rounds import Lockstep, Round
from hitab_core import RESERVED_NAMES, Mode
from hitab_core.orders import Order, Report
from hitab_ros import ListenedTime, names, qos
from hitab_ros.messages.conversions import message_of
from hitab_ros.messages.stamps import time_of
from hitab_ros.timing import HEARTBEAT_S, POLL_S

EPISODES_KNOWN = 8
"""How many past episodes are remembered, so that a late report does not seem to begin one."""

CALM_MODES = (Mode.IDLE, Mode.PERFORMING)

Episode = tuple[int, int]
"""An episode's seed of the run, and its number in the run."""


class CommanderLink:
    """Makes a commander decide when something has changed, and at a fixed rate.

    In real time the commander decides at once when a subordinate's activity changes, when all have
    reported again, and when its own commander or a person gives it an order. In lockstep it
    decides in its turn; see `hitab_commander.rounds`.

    Attributes:
        body: the group.
        group: publishes its status.
        seconds: the subordinates' time, s: the number of complete reports times the period.
        calm: whether another decision would be the same as the last one, which changed nothing and
            drew no random number; then none is made at the fixed rate.
    """

    def __init__(self, node: AgentNode) -> None:
        """Start to receive reports and give orders."""
        agent, shared = node.agent, node.shared
        settings = GroupSettings.declare(node)
        self._node = node
        self._agent = agent
        self._exchange = shared.exchange
        self.body: CommanderBody = agent.body
        self.group = GroupStatus(node)
        self._lockstep = Lockstep(self.body)
        self._gate = RoundGate(shared.exchange)
        self.seconds = 0.0
        self._listened = ListenedTime(max(POLL_S, 2.0 / self.body.kind.rate))
        self._episode: Episode | None = None
        self._episodes: list[Episode] = []
        self._percept = msg.Percept()
        self._decided = False
        self.calm = False
        self._silent: list[bool] = []
        self._look_at = 0.0
        self._hear_sign = node.guard.wrap("signs of life", self._on_sign)
        self._orders = PublishedTopic(
            node, msg.Order, names.ORDER, qos.LATCHED, latched=self._show_order
        )
        # Observers find here also the reports that came another way.
        self._reports = PublishedTopic(node, msg.Reports, names.REPORTS, qos.EVENTS)
        subscription = HeardTopic(node, msg.Reports, names.REPORTS, qos.EVENTS, self._on_topic)
        self._reports.mirror, subscription.mirror = subscription, self._reports
        node.endpoints.topics += [self.group.topic, self._orders, subscription]
        if shared.host is not None:
            node.endpoints.topics.append(self._reports)
        stored = node.memory.values
        epoch = stored.get("epoch")
        self.body.enlist(
            settings.roles,
            # An epoch larger than that of any earlier process, even if the clock was set back.
            max(time.time_ns(), epoch + 1 if isinstance(epoch, int) else 0),
            self._listened.now(),
            asks_position=settings.asks_position,
        )
        self.body.on_order = self._on_order
        self._in_force = self.body.order
        self._exchange.command(node, settings.roles, self._on_reports, self._on_loss)
        self._resume(str(stored.get("order", "")) if node.memory.performed is not None else "")
        shared.scheduler.every(1.0 / self.body.kind.rate, self._on_time, node.guard)

    def close(self) -> None:
        """Do nothing: subordinates continue to follow their orders."""

    def _resume(self, order: str) -> None:
        """Resume the order of the previous process, or publish that there is none."""
        if order and not self.body.give_again(order):
            self._node.get_logger().warning(
                f'the order in force, "{order}", no longer exists; '
                "subordinates continue with it until another order is given"
            )
        if not self.body.order.sequence:
            self._on_order(self.body.order)

    # -- hearing ----------------------------------------------------------------------------

    def _on_topic(self, message: msg.Reports) -> None:
        if message.process != self._node.shared.name:
            reports = self._exchange.believed(message.reports, message.process)
            self._hear(reports, message.process)

    def _on_reports(self, reports: Sequence[Report | msg.Report], process: str) -> None:
        self._hear(reports, process)
        if self._reports.is_listened_to:
            shown = [
                report if isinstance(report, msg.Report) else message_of(msg.Report, report)
                for report in reports
            ]
            self._reports.publish(msg.Reports(reports=shown, process=self._node.shared.name))

    def _hear(self, reports: Sequence[Report | msg.Report], process: str) -> None:
        body = self.body
        now = self._listened.now()
        changed = restart = False
        newest = body.number
        for report in reports:
            if (member := body.members.get(report.agent)) is not None:
                newest = max(newest, (report.epoch, report.sequence))
                if member.process != process:
                    member.process = process
                    self._node.shared.signs.follow(process, self._hear_sign)
            news, complete = self._lockstep.hear(report, now)
            changed |= news
            if complete is not None:
                self._perceive_round(complete)
            elif not self._lockstep.active and report.agent in body.members:
                restart |= self._begins_episode(report)
                if report.back:
                    self._percept.back = changed = True
        if newest > body.number:
            body.outbid(newest)
        if self._lockstep.active:
            self.group.changed |= changed
            self.calm = False
            return
        # Of unasked members, a change of the time alone changes no decision.
        self.calm &= not (changed or restart or body.order.asks)
        self._hear_all(changed=changed, restart=restart)

    def _on_sign(self, sign: msg.Alive) -> None:
        if not self._lockstep.active and self.body.hear_sign(sign, self._listened.now()):
            self._hear_all()

    def _on_loss(self, lost: Collection[str]) -> None:
        """Repeat the order soon for subordinates that were restarted."""
        self.body.lose(lost)
        self._look_at = 0.0

    def _hear_all(self, *, changed: bool = False, restart: bool = False) -> None:
        """Decide if something has changed, or if all members have been heard again."""
        body = self.body
        self._percept.cycle = body.cycle
        everybody = body.round_ends()
        if everybody:
            self.seconds += body.kind.report_period
        self.group.changed |= changed
        if changed or everybody or restart:
            self.decide(restart=restart)
        else:
            self._agent.sense((), (), self._percept.cycle, self.seconds)

    def _begins_episode(self, report: Report | msg.Report) -> bool:
        """Whether a report shows that the subordinates' world has begun an episode."""
        found = (report.seed, report.episode)
        if found == self._episode:
            return False
        if self._episode is not None and not (any(found) or report.cycle):
            return False  # the agent has just started, and has no percept yet
        if found in self._episodes and any(
            (other.seed, other.episode) != found for _, other in self.body.present()
        ):
            return False  # the report is late: all would report an episode that is played again
        self._episode = found
        self._episodes = [*self._episodes[1 - EPISODES_KNOWN :], found]
        self._percept.seed, self._percept.episode = found
        return True

    # -- deciding in lockstep ---------------------------------------------------------------

    def _perceive_round(self, present: Round) -> None:
        """Perceive the round's reports, report to the superior, and wait for its order."""
        percept = self._percept
        percept.sequence = present.number
        percept.cycle = present.cycle
        percept.stamp = time_of(present.seconds)
        percept.seed, percept.episode = present.seed, present.episode
        percept.look, percept.restart, percept.lockstep = present.look, present.restart, True
        percept.back = present.back
        self.seconds = present.seconds
        self._episode = present.seed, present.episode
        with self._exchange.at_once():
            self._node.take_in(percept, self.seconds)
        self._gate.begin(
            present.number,
            self._node.awaited_orders(),
            lambda: self._decide_round(present),
            look=present.look,
        )

    def _decide_round(self, present: Round) -> None:
        """Decide, if a decision is due, and give the order of the round."""
        if self._lockstep.is_due(present):
            self._node.answer(self._percept)
        percept = self._percept
        percept.restart = percept.look = percept.lockstep = percept.back = False
        order = replace(self.body.order, round=present.number)
        self._publish(order)
        self._node.remember()

    # -- deciding in real time --------------------------------------------------------------

    def _on_time(self) -> None:
        body, now = self.body, time.monotonic()
        body.now = self._listened.now()
        if self.calm and now < self._look_at and not self.group.changed:
            return
        silent = [body.is_silent(name) for name in body.members]
        if silent != self._silent:
            self._silent, self.calm = silent, False
        if not (self._decided or self.calm or self._lockstep.active):
            self.decide()
        self._decided = False
        if now >= self._look_at:
            self._look_at = now + HEARTBEAT_S
            if not (self._lockstep.active or all(map(body.has_order, body.members))):
                self._publish(body.order)
        self.group.publish_if_changed()

    def decide(self, *, restart: bool = False) -> None:
        """Tick, if there are subordinates to command, and give the resulting order at once.

        In lockstep, the decision waits for the commander's turn in the next round.
        """
        if self._lockstep.active:
            self._lockstep.expect()
            self._node.remember()
            return
        percept = self._percept
        percept.restart |= restart
        percept.stamp = self._node.get_clock().now().to_msg()
        self._decided, self.calm = True, False
        with self._exchange.held():
            if self.body.ready:
                agent = self._agent
                before = agent.active_path, agent.draws, agent.mode
                self._node.take_in(percept, self.seconds)
                self._node.answer(percept)
                percept.restart = percept.back = False
                # The next decision would be the same, unless something changes.
                self.calm = agent.mode in CALM_MODES and RESERVED_NAMES.isdisjoint(before[0])
                self.calm &= before == (agent.active_path, agent.draws, agent.mode)
            else:
                self._agent.sense((), (), percept.cycle, self.seconds)
                if self._node.superior is not None:
                    self._node.superior.tell()
        self._node.remember()

    # -- ordering ---------------------------------------------------------------------------

    def _on_order(self, order: Order) -> None:
        # Store the order before publishing it: a process that is killed in between must not
        # return to the previous order.
        self._node.remember()
        if not self._percept.lockstep:  # in lockstep, the end of the round publishes it
            self._publish(order)
        self.group.changed = True

    def _publish(self, order: Order) -> None:
        self._in_force = order
        self._exchange.give(self._agent.name, order)
        self._show_order()

    def _show_order(self) -> None:
        if self._orders.end is not None:
            order, name = self._in_force, self._agent.name
            self._orders.publish(message_of(msg.Order, order, commander=name, order=order.name))
