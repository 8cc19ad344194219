"""Orders of a commander to its subordinates, and what these report to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

Number = tuple[int, int]
"""Epoch and sequence: an order with a larger one is newer."""

OTHERS = ""
"""Receiver of an order: every subordinate that it does not name or give a role."""


@dataclass(frozen=True, slots=True)
class Order:
    """What a commander orders all its subordinates to do.

    Attributes:
        epoch: of the commander's process; a restarted one's is larger.
        sequence: counts up within the epoch; 0: it has not ordered anything yet.
        name: what the commander calls it, such as ``Attack``; it is a behavior of the commander.
        behaviors: what is to be performed, such as ``GoTo(ball)``, by receiver: a subordinate's
            name, else a role, else `OTHERS`. Empty text: perform nothing.
        report: features whose values the subordinates are to report.
        report_position: whether they are to report where they are.
        report_states: whether they are to report what is active inside their top-level behavior.
        report_period: s of a subordinate's own time between two reports of values that change.
        round: in lockstep, the number of the round that the order ends; 0: given out of turn.
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
    def number(self) -> Number:
        """Which of two orders is newer: the larger one."""
        return self.epoch, self.sequence

    def behavior_for(self, name: str, role: str) -> str | None:
        """Return what a subordinate is to perform; None: it goes on with what it does."""
        for receiver in (name, role, OTHERS):
            if receiver in self.behaviors:
                return self.behaviors[receiver]
        return None


@dataclass(frozen=True, slots=True)
class Report:
    """What one subordinate tells its commander.

    Attributes:
        agent: its name.
        epoch, sequence: of the last order that it has heard; 0: none.
        waits: whether that order has not been taken up yet.
        mode: of the agent.
        path: its top-level behavior and, if asked for, the active states inwards; empty if it is
            idle.
        flags: raised by its top-level behavior since that order.
        values: of the features that the commander has asked for; NaN: has no such value.
        position: x and y, m; empty: not asked for, or unknown.
        cycle, episode, seed: of its last percept.
        seconds: the agent's own time, s.
        round: in lockstep, the number of the last percept; 0: in real time.
        look: whether that percept was only to be looked at.
        restart: whether it began an episode.
    """

    agent: str
    epoch: int = 0
    sequence: int = 0
    waits: bool = False
    mode: str = ""
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
