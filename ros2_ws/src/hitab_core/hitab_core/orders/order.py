"""A commander's orders to its subordinates, and their reports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

OrderId = tuple[int, int]
"""Epoch and sequence; the larger one is newer."""

ALL_OTHERS = ""
"""Receiver of an order: every subordinate not addressed by name or role."""


@dataclass(frozen=True, slots=True)
class Order:
    """A commander's order to all its subordinates.

    Attributes:
        epoch: epoch of the commander's process; larger after a restart.
        sequence: counts up within the epoch; 0 before the first order.
        name: name of the order, such as ``Attack``; a behavior of the commander.
        behaviors: behavior to perform, such as ``GoTo(ball)``, by receiver: a subordinate's name,
            a role, or `ALL_OTHERS`. An empty text means none.
        report: features whose values the subordinates should report.
        report_position: whether they should report their position.
        report_states: whether they should report the active states of their top-level behavior.
        report_period: seconds, in a subordinate's own time, between reports of changing values.
        round: number of the round that the order ends, in lockstep; 0 outside of rounds.
    """

    epoch: int = 0
    sequence: int = 0
    name: str = ""
    behaviors: Mapping[str, str] = field(default_factory=dict)
    report: tuple[str, ...] = ()
    report_position: bool = False
    report_states: bool = False
    report_period: float = 0.5
    round: int = 0

    @property
    def number(self) -> OrderId:
        """Epoch and sequence, to compare orders: the larger is newer."""
        return self.epoch, self.sequence

    @property
    def asks(self) -> bool:
        """Whether subordinates should report values or their positions."""
        return bool(self.report) or self.report_position

    def behavior_for(self, name: str, role: str) -> str | None:
        """Return the behavior that a subordinate should perform; None to continue."""
        for receiver in (name, role, ALL_OTHERS):
            if receiver in self.behaviors:
                return self.behaviors[receiver]
        return None


@dataclass(frozen=True, slots=True)
class Report:
    """A subordinate's report to its commander.

    Attributes:
        agent: name of the subordinate.
        epoch, sequence: number of the last order received; 0 before the first.
        waits: whether that order is still pending.
        mode: mode of the agent.
        stopped: whether its robot may not act.
        path: the top-level behavior and, if requested, the active states inwards; empty if idle
            or stopped.
        flags: flags that its top-level behavior has raised since that order.
        values: values of the features that the commander requested; NaN without a value.
        position: x and y, m; empty if not requested or unknown.
        cycle, episode, seed: cycle, episode and seed of the last percept.
        seconds: the agent's own time, s.
        round: number of the last percept, in lockstep; 0 in real time.
        look: whether that percept was for observation only.
        restart: whether that percept began an episode.
        back: whether the world went back to that percept's cycle.
    """

    agent: str
    epoch: int = 0
    sequence: int = 0
    waits: bool = False
    mode: str = ""
    stopped: bool = False
    path: Sequence[str] = ()
    flags: Sequence[str] = ()
    values: Sequence[float] = ()
    position: Sequence[float] = ()
    cycle: int = 0
    episode: int = 0
    seed: int = 0
    seconds: float = 0.0
    round: int = 0
    look: bool = False
    restart: bool = False
    back: bool = False
