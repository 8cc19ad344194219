"""Stop machine of a robot or world: states between standing still and acting.

The machine is independent of ROS. A robot's relay has one, or its agent, if its link has no relay.
All states and events::

    state      event                                          next state
    any        a cause appears: emergency stop, silent        stopping
               agent, dead sensor, start of the process
    stopping   it stands still                                stopped
    stopped    it moves                                       stopping
    stopped    the last cause is gone                         stopped; armed if it re-arms itself
    stopped    a person re-arms it, no cause is left          armed
    any other  a person re-arms it                            the same; refused, with the reason

A stopped robot therefore never moves again by itself: it waits for a person, after any cause and
after any restart of its process.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from enum import StrEnum

JUST_STARTED = "it has just started"
"""Reason of a robot that has not acted since its start and has no other."""


class StopState(StrEnum):
    """States; the values are those of `hitab_msgs.msg.StopState`."""

    ARMED = "armed"
    STOPPING = "stopping"
    STOPPED = "stopped"


class StopMachine:
    """Whether one robot may act.

    Attributes:
        causes: present reasons to stand still, by name.
        why: reason of the stop, or `JUST_STARTED`; empty if armed.
        stop: number of this stop, larger than those of earlier stops, also of other processes.
        stands: whether the robot stood still at the last look.
    """

    def __init__(
        self,
        *,
        rearms: bool = False,
        changed: Callable[[], None] = lambda: None,
        number: Callable[[], int] = time.time_ns,
    ) -> None:
        """Start stopped, since the previous process may have been stopped.

        Args:
            rearms: whether the robot re-arms itself when no cause is left.
            changed: called after each change.
            number: returns a number for a stop, larger each time.
        """
        self.causes: dict[str, str] = {}
        self.why = self._last = JUST_STARTED
        self.stop = number()
        self.stands = False
        self._rearms = rearms
        self._changed = changed
        self._number = number

    @property
    def state(self) -> StopState:
        """State of the robot."""
        if not self.why:
            return StopState.ARMED
        return StopState.STOPPED if self.stands else StopState.STOPPING

    def cause(self, name: str, why: str) -> None:
        """Set a reason to stand still; an empty text removes the cause."""
        if self.causes.get(name, "") == why:
            return
        if not why:
            del self.causes[name]
        else:
            if name not in self.causes:
                self.stop = max(self._number(), self.stop + 1)
                self._last = why
            if not self.causes and self.why != JUST_STARTED:
                self.why = why
            self.causes[name] = why
        self._changed()

    def look(self, *, stands: bool) -> None:
        """Note whether the robot stands still; call this periodically."""
        before, self.stands = self.stands, stands
        if self._rearms and self.state is StopState.STOPPED and not self.causes:
            self.why = ""
            self._changed()
        elif before is not stands and self.why:
            self._changed()

    def arm(self, stop: int = 0) -> str:
        """Re-arm the robot; return the reason of a refusal, or an empty text.

        Args:
            stop: number of the stop to end; 0 for any.
        """
        if not self.why:
            return ""
        if self.causes:
            return "; ".join(self.causes.values())
        if stop not in (0, self.stop):
            return f"it has stopped once more meanwhile: {self._last}"
        if not self.stands:
            return "it still moves"
        self.why = ""
        self._changed()
        return ""
