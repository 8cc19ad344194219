"""The body of a commander: its group of subordinates, as far as it has heard of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from hitab_commander.aggregation import mean_position, observed, summed_up
from hitab_commander.kind import CommanderKind, GroupFeature, OrderMap, Over, Pick
from hitab_commander.roll_call import RollCall
from hitab_core.commanding import OTHERS, Number, Order, Report

NAN = math.nan


@dataclass(slots=True)
class Member:
    """A subordinate.

    Attributes:
        role: in the group; empty: none.
        report: what the commander decides by: its last report, in lockstep its report of the
            last round; None: nothing yet.
        latest: its last report, for people who watch.
        heard_at: s, when that came, or when the commander began to wait for it.
    """

    role: str = ""
    report: Report | None = None
    latest: Report | None = None
    heard_at: float = 0.0


class CommanderBody:
    """Hears the subordinates' reports and gives them orders; knows no middleware.

    Times are in s on a clock of the caller's, which never goes back.

    Attributes:
        members: the subordinates, by name, in order.
        order: in force; sequence 0 as long as none was given.
        on_order: called with each new order, at once; whoever carries orders sets it.
        now: the time, which in real time decides who is silent.
        roll: who has reported in a round of lockstep.
    """

    def __init__(self, name: str, kind: CommanderKind) -> None:
        self.name = name
        self.kind = kind
        self.members: dict[str, Member] = {}
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
            roles: by name; an empty role is none.
            epoch: a number larger than that of any commander of this name before.
            now: the time.
            asks_position: have them report where they are, since a superior asks for it.
        """
        self._asks_position = asks_position or self.kind.asks_position
        self.members = {name: Member(role, heard_at=now) for name, role in roles.items()}
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
        """Take a percept: there is none, the reports have been heard as they came."""

    def act(self) -> tuple[Sequence[float], str]:
        """Return no action: orders are given while behaviors are performed."""
        return (), ""

    @property
    def position(self) -> tuple[float, float] | None:
        """Where the group is on average, m; None if unknown."""
        return mean_position(report.position for _, report in self.present())

    # -- hearing ----------------------------------------------------------------------------

    def hear(self, report: Report, now: float) -> bool:
        """Take a report; return whether something else than a value has changed.

        A report of somebody who is not under this command is ignored.
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
        member.latest, member.heard_at = report, now
        if before is None or was_silent:
            return True
        return (
            before.sequence != report.sequence
            or before.epoch != report.epoch
            or before.waits != report.waits
            or list(before.flags) != list(report.flags)
            or list(before.path) != list(report.path)
        )

    def _change_time(self, report: Report, member: Member) -> None:
        """Go over to lockstep or to real time if a report shows that its world has."""
        roll = self.roll
        if report.round and not roll.round:
            roll.begin([name for name in self.members if self.is_silent(name)])
        elif not report.round and roll.round:
            # One that has just been started has not perceived yet in which time it lives.
            before = member.latest
            if before is not None and before.round and report.cycle >= before.cycle:
                roll.end()

    def round_ends(self) -> bool:
        """Whether everybody has reported since this was last so; if so, another round begins.

        Who has fallen silent is not waited for.
        """
        present = {name for name, _ in self.present()}
        if not self._unheard.isdisjoint(present):
            return False
        self._unheard = present
        return True

    def is_silent(self, name: str) -> bool:
        """Whether a subordinate was not heard of for longer than the deadline.

        In lockstep, whether it did not report in the last round that it owed a report of.
        """
        if self.roll.round:
            return name in self.roll.missing
        return self.now - self.members[name].heard_at > self.kind.deadline

    def knows_of(self, name: str) -> bool:
        """Whether a subordinate has heard of this commander, and is heard."""
        latest = self.members[name].latest
        return latest is not None and latest.epoch == self.order.epoch and not self.is_silent(name)

    @property
    def ready(self) -> bool:
        """Whether there is anybody to command, and nobody is still waited for."""
        waited_for = any(
            member.report is None and not self.is_silent(name)
            for name, member in self.members.items()
        )
        return not waited_for and any(True for _ in self.present())

    def present(self, role: str = "") -> Iterator[tuple[str, Report]]:
        """Go through those that are heard of, in order: names and last reports."""
        for name, member in self.members.items():
            if member.report is None or self.is_silent(name):
                continue
            if not role or member.role == role:
                yield name, member.report

    @property
    def number(self) -> Number:
        """Which order is in force."""
        return self.order.number

    def obeys(self, name: str) -> bool:
        """Whether a subordinate has said that it performs what is ordered."""
        member = self.members[name]
        report = member.latest
        if report is None or (report.epoch, report.sequence) != self.number or report.waits:
            return False
        behavior = self.order.behavior_for(name, member.role)
        return behavior is None or (report.path[0] if report.path else "") == behavior

    # -- perceiving -------------------------------------------------------------------------

    def feature(self, feature: GroupFeature) -> float:
        """Return a fact about the group; NaN if it has no value."""
        asked, number = self._asked, self.number
        return summed_up(
            (observed(r, feature.of, asked, number) for _, r in self.present(feature.role)),
            feature.over,
        )

    def feature_of(self, feature: GroupFeature, name: str | None) -> float:
        """Return what is observed in one subordinate; NaN if it is silent or there is none."""
        for present, report in self.present():
            if present == name:
                return observed(report, feature.of, self._asked, self.number)
        return NAN

    @property
    def fraction_silent(self) -> float:
        """The share of the subordinates that are silent."""
        if not self.members:
            return 0.0
        return sum(self.is_silent(name) for name in self.members) / len(self.members)

    def picked(self, pick: Pick) -> str | None:
        """Return the subordinate that is picked; None if there is none now."""
        if pick.number:
            names = [n for n, m in self.members.items() if not pick.role or m.role == pick.role]
            return names[pick.number - 1] if pick.number <= len(names) else None
        best: str | None = None
        best_value = NAN
        for name, report in self.present(pick.role):
            value = observed(report, pick.of, self._asked, self.number)
            if math.isnan(value):
                continue
            larger = value > best_value
            if best is None or (larger if pick.over is Over.MAXIMUM else value < best_value):
                best, best_value = name, value
        return best

    # -- ordering ---------------------------------------------------------------------------

    def give(self, order: OrderMap, chosen: str | None = None) -> None:
        """Give an order, unless it is in force already.

        Args:
            order: what to order.
            chosen: the subordinate that it is about; None: nobody can be picked now, so that an
                order that is about somebody is not given.
        """
        if order.parameter and chosen is None:
            return
        label = f"{order.name}({chosen})" if order.parameter else order.name
        if label == self.given:
            return
        ordered = {
            chosen or OTHERS if order.parameter and receiver == order.parameter else receiver: what
            for receiver, what in order.behaviors.items()
        }
        if ordered.get(OTHERS) is not None and None in ordered.values():
            # A message cannot tell some to go on and all others to do something: it names these.
            ordered = {
                name: next(ordered[r] for r in (name, member.role, OTHERS) if r in ordered)
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

    def outbid(self, number: Number) -> None:
        """Give the order in force again, with a newer number than one that is not its own.

        Somebody else has ordered in this commander's name; subordinates would take all that
        follows for older.
        """
        self.order = replace(self.order, epoch=number[0] + 1)
        self.on_order(self.order)

    def give_again(self, label: str) -> bool:
        """Give the order that was called so before a restart, with the meaning that it has now.

        Returns:
            whether there is still such an order, and whom it is about.
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
