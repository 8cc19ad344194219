"""The body of a commander: the group of its subordinates, as known from their reports."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from hitab_commander.aggregation import observed, of_positions, summed_up
from hitab_commander.kinds.kind import CommanderKind, GroupFeature, OrderMap, Over, Pick
from hitab_commander.roll_call import RollCall
from hitab_core.orders import ALL_OTHERS, Order, OrderId, Report

NAN = math.nan


class SignOfLife(Protocol):
    """A process's sign of life, with the cycle, episode and seed of its agents' last percepts.

    All three are zero if its agents report their percepts themselves.
    """

    process: str
    cycle: int
    episode: int
    seed: int


@dataclass(slots=True)
class GroupMember:
    """A subordinate, as its commander knows it.

    Attributes:
        role: the subordinate's role; empty if none.
        report: the report on which the commander decides: in real time the last one, in lockstep
            the one of the last round; None before the first.
        latest: the last report, for observers.
        heard_at: time, s, of the last report or sign of life; before the first, the time at which
            the commander began to wait for it.
        process: name of the process that sent ``latest``; empty if unknown.
        cycle: the last cycle that it is known to have perceived.
        beaten: whether there was a report since the process's last sign of life.
    """

    role: str = ""
    report: Report | None = None
    latest: Report | None = None
    heard_at: float = 0.0
    process: str = ""
    cycle: int = 0
    beaten: bool = False


class CommanderBody:
    """Receives the subordinates' reports and gives orders; independent of any middleware.

    Times are in s on the caller's clock, which must be monotonic.

    Attributes:
        members: the subordinates, by name, in order.
        order: the order in force; sequence 0 until one is given.
        on_order: called at once with each new order; set by the code that sends orders.
        now: the present time, s; in real time, members are silent by it.
        roll: the members that have reported in a lockstep round.
    """

    def __init__(self, name: str, kind: CommanderKind) -> None:
        self.name = name
        self.kind = kind
        self.members: dict[str, GroupMember] = {}
        self.roll = RollCall(())
        self._asks_position = kind.asks_position
        self.order = self._blank(0)
        self.given = ""
        self.on_order: Callable[[Order], None] = lambda order: None
        self.now = 0.0
        self._unheard: set[str] = set()
        self._asked = kind.asked

    def enlist(
        self,
        roles: Mapping[str, str],
        epoch: int,
        now: float = 0.0,
        *,
        asks_position: bool = False,
    ) -> None:
        """Take command of subordinates.

        Args:
            roles: roles by the subordinates' names; empty for no role.
            epoch: a number larger than that of any earlier commander of this name.
            now: the present time, s.
            asks_position: whether a superior needs the subordinates' positions.
        """
        self._asks_position = asks_position or self.kind.asks_position
        self.members = {name: GroupMember(role, heard_at=now) for name, role in roles.items()}
        self.roll = RollCall(self.members)
        self.order = self._blank(epoch)
        self.given = ""
        self.now = now

    def _blank(self, epoch: int) -> Order:
        kind = self.kind
        return Order(
            epoch,
            report=kind.asked,
            report_position=self._asks_position,
            report_states=kind.asks_states,
            report_period=kind.report_period,
        )

    # -- a body -----------------------------------------------------------------------------

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Do nothing: a commander has no percept, and handles reports on arrival."""

    def act(self) -> tuple[Sequence[float], str]:
        """Return no action: orders are given while behaviors are performed."""
        return (), ""

    @property
    def position(self) -> tuple[float, float] | None:
        """The mean position of the group, m; None if unknown."""
        x, y = self.of_group("x"), self.of_group("y")
        return None if math.isnan(x) else (x, y)

    def of_group(self, part: str) -> float:
        """Return the mean x or y of the group, or its spread, m; NaN if unknown."""
        return of_positions(part, (report.position for _, report in self.present()))

    # -- hearing ----------------------------------------------------------------------------

    def hear(self, report: Report, now: float) -> bool:
        """Take a report; return whether more than values has changed.

        Reports of agents that are not subordinates are ignored.
        """
        self.now = now
        self._unheard.discard(report.agent)
        member = self.members.get(report.agent)
        if member is None:
            return False
        before = member.latest
        was_silent = before is None or self.is_silent(report.agent)
        self._change_time(report, member)
        known = member.report
        if not (self.roll.round and known is not None and report.round == known.round):
            member.report = report
        member.latest, member.heard_at, member.beaten = report, now, True
        member.cycle = report.cycle
        return before is None or was_silent or _activity(before) != _activity(report)

    def _change_time(self, report: Report, member: GroupMember) -> None:
        """Switch to lockstep or to real time if a report shows that the world has switched."""
        roll = self.roll
        if report.round and not roll.round:
            roll.begin([name for name in self.members if self.is_silent(name)])
        elif not report.round and roll.round:
            # A member that has just started does not know yet whether its world is in lockstep.
            before = member.latest
            if before is not None and before.round and report.cycle >= before.cycle:
                roll.end()

    def hear_sign(self, sign: SignOfLife, now: float) -> bool:
        """Take a sign of life of a process: its agents do what they have reported.

        They have perceived the cycle that it tells, unless they report a new episode themselves. A
        silent member remains silent, since its reports may have been lost; it reports again when
        the order is repeated.

        Returns:
            Whether the time of a member may have gone on; that of a paused world has not.
        """
        self.now = now
        goes_on = False
        for name, member in self.members.items():
            if member.process == sign.process and not self.is_silent(name):
                if not member.beaten and not (sign.cycle and member.cycle == sign.cycle):
                    goes_on = True
                    self._unheard.discard(name)
                    latest = member.latest
                    if sign.cycle and latest is not None and _episode(latest) == _episode(sign):
                        member.cycle = sign.cycle
                member.heard_at, member.beaten = now, False
        return goes_on

    def lose(self, names: Collection[str]) -> None:
        """Take subordinates for silent until they report again: they were restarted."""
        for name in names:
            member = self.members[name]
            if member.latest is not None:
                member.heard_at = -math.inf

    @property
    def cycle(self) -> int:
        """The latest cycle that all have perceived: the world's once all have told it."""
        return min((self.members[name].cycle for name, _ in self.present()), default=0)

    def round_ends(self) -> bool:
        """Return whether all members have reported in this round; if so, begin the next round.

        Silent members do not count.
        """
        present = {name for name, _ in self.present()}
        if not self._unheard.isdisjoint(present):
            return False
        self._unheard = present
        return True

    def is_silent(self, name: str) -> bool:
        """Return whether a subordinate has sent no report for longer than the deadline.

        In lockstep, the subordinate is silent if it missed the last round in which it had to
        report.
        """
        if self.roll.round:
            return name in self.roll.missing
        return self.now - self.members[name].heard_at > self.kind.deadline

    def knows_of(self, name: str) -> bool:
        """Whether a subordinate knows this commander's epoch and is not silent."""
        latest = self.members[name].latest
        return latest is not None and latest.epoch == self.order.epoch and not self.is_silent(name)

    def has_order(self, name: str) -> bool:
        """Whether a subordinate that is not silent has reported the order in force."""
        latest = self.members[name].latest
        newest = latest is not None and (latest.epoch, latest.sequence) >= self.order.number
        return newest and not self.is_silent(name)

    @property
    def ready(self) -> bool:
        """Whether there are subordinates to command, and all but silent ones have reported."""
        waited_for = any(
            member.report is None and not self.is_silent(name)
            for name, member in self.members.items()
        )
        return not waited_for and any(True for _ in self.present())

    def present(self, role: str = "") -> Iterator[tuple[str, Report]]:
        """Yield the names and last reports of the members that are not silent, in order."""
        for name, member in self.members.items():
            if member.report is None or self.is_silent(name):
                continue
            if not role or member.role == role:
                yield name, member.report

    @property
    def number(self) -> OrderId:
        """The number of the order in force."""
        return self.order.number

    def obeys(self, name: str) -> bool:
        """Return whether a subordinate has reported that it performs the order in force."""
        member = self.members[name]
        report = member.latest
        if report is None or (report.epoch, report.sequence) != self.number:
            return False
        if report.waits or report.stopped:
            return False
        behavior = self.order.behavior_for(name, member.role)
        return behavior is None or (report.path[0] if report.path else "") == behavior

    # -- perceiving -------------------------------------------------------------------------

    def feature(self, feature: GroupFeature, name: str | None = None) -> float:
        """Return a feature of the group, or of one subordinate; NaN if it has no value."""
        if feature.over is Over.GROUP:
            return self.of_group(feature.part)
        asked, number, of = self._asked, self.number, feature.of
        if feature.over is Over.VALUE:
            values = (observed(r, of, asked, number) for one, r in self.present() if one == name)
            return next(values, NAN)
        present = self.present(feature.role)
        return summed_up((observed(r, of, asked, number) for _, r in present), feature.over)

    @property
    def fraction_silent(self) -> float:
        """The share of the subordinates that are silent."""
        if not self.members:
            return 0.0
        return sum(self.is_silent(name) for name in self.members) / len(self.members)

    def picked(self, pick: Pick) -> str | None:
        """Return the subordinate that a target picks; None if it can pick none now."""
        if pick.number:
            names = [n for n, m in self.members.items() if not pick.role or m.role == pick.role]
            return names[pick.number - 1] if pick.number <= len(names) else None
        seen = {
            name: value
            for name, report in self.present(pick.role)
            if not math.isnan(value := observed(report, pick.of, self._asked, self.number))
        }
        # min and max return the first of equal members.
        best = max if pick.over is Over.MAXIMUM else min
        return best(seen, key=seen.__getitem__, default=None)

    # -- ordering ---------------------------------------------------------------------------

    def give(self, order: OrderMap, chosen: str | None = None) -> None:
        """Give an order, unless it is in force already.

        Args:
            order: the order to give.
            chosen: the subordinate bound to the order's parameter. None, if the target can pick
                no subordinate now: then an order with a parameter is not given.
        """
        if order.parameter and chosen is None:
            return
        label = f"{order.name}({chosen})" if order.parameter else order.name
        if label == self.given:
            return
        ordered = {
            chosen or ALL_OTHERS
            if order.parameter and receiver == order.parameter
            else receiver: what
            for receiver, what in order.behaviors.items()
        }
        if ordered.get(ALL_OTHERS) is not None and None in ordered.values():
            # An order to all others has no exceptions in a message, so name each member instead.
            ordered = {
                name: next(ordered[r] for r in (name, member.role, ALL_OTHERS) if r in ordered)
                for name, member in self.members.items()
            }
        self.given = label
        self.order = replace(
            self.order,
            sequence=self.order.sequence + 1,
            name=label,
            behaviors={r: what for r, what in ordered.items() if what is not None},
        )
        self.on_order(self.order)

    def outbid(self, number: OrderId) -> None:
        """Repeat the order in force with a newer number than a foreign order has.

        Another process has given an order in this commander's name. Without a newer number,
        subordinates would ignore all further orders as older.
        """
        self.order = replace(self.order, epoch=number[0] + 1)
        self.on_order(self.order)

    def give_again(self, label: str) -> bool:
        """Give the order that had this label before a restart, as it is defined now.

        Returns:
            Whether the order, and the subordinate in its label, still exist.
        """
        for order in self.kind.orders:
            if not order.parameter and label == order.name:
                self.give(order)
                return True
            for name in self.members if order.parameter else ():
                if label == f"{order.name}({name})":
                    self.give(order, name)
                    return True
        return False


def _episode(told: Report | SignOfLife) -> tuple[int, int]:
    return told.seed, told.episode


def _activity(report: Report) -> tuple[object, ...]:
    """Return everything in a report except times and values."""
    number = report.epoch, report.sequence
    return number, report.waits, report.stopped, list(report.flags), list(report.path)
