"""Acting on a percept; an agent that cannot act does nothing and reports why.

An agent that decides although a feature has no value acts, and reports that, too.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence

from hitab_core import Agent, HitabError, each_once
from hitab_ros import Guard
from hitab_ros.answering import what_went_wrong

Action = tuple[Sequence[float], str]
"""A body's action and message."""

NO_ACTION: Action = ((), "")

TICK = "tick"
"""The fault of an agent that does nothing because it cannot perceive, decide or act."""

VALUES = "values"
"""The fault of an agent that decides without the values of some features."""

FEATURES_FAULT = "features"
"""The fault of an agent whose domain's code raises where it should read features."""


class GuardedTick:
    """Ticks an agent; never raises.

    Attributes:
        fault: why the agent does nothing; empty if nothing is wrong.
    """

    def __init__(self, agent: Agent, guard: Guard) -> None:
        """Prepare to tick.

        Args:
            agent: to tick.
            guard: of its node; its faults include this one.
        """
        self.fault = ""
        self._failed_in = ("", "")
        self._agent = agent
        self._guard = guard

    def perceived(self) -> None:
        """Report features that cannot be read, whether decisions need them or not."""
        self._show(FEATURES_FAULT, failing(self._agent))

    def act(self) -> Action:
        """Have the agent decide and act; return its action and message, or nothing if it fails."""
        agent = self._agent
        try:
            agent.tick()
            action = _action(*agent.body.act())
        except Exception as error:
            self.fail(error)
            return NO_ACTION
        self.fault = ""
        self._show(TICK, "")
        if lacking := "; ".join(agent.context.feature_cache.lacking()):
            self._failed_in = self._doing
            lacking = f"{agent.name} decides without needed values: {lacking}"
        self._show(VALUES, lacking)
        return action

    def fail(self, error: Exception) -> None:
        """Report an error that kept the agent from perceiving, deciding or acting."""
        agent, why = self._agent, what_went_wrong(error)
        self._failed_in = self._doing
        if why != self.fault:
            self.fault = why
            told = f"{agent.name} has done nothing since cycle {agent.cycle}: {why}"
            self._show(TICK, told, cause=why)

    def clear_if_past(self) -> None:
        """Clear the faults if the agent no longer performs the behavior that had them."""
        if self._failed_in != self._doing:
            self.fault = ""
            self._show(TICK, "")
            if self._guard.faults.text(VALUES):
                self._agent.context.feature_cache.missed.clear()
                self._show(VALUES, "")

    @property
    def _doing(self) -> tuple[str, str]:
        return self._agent.mode.value, self._agent.behavior

    def _show(self, key: str, fault: str, cause: str = "") -> None:
        if fault:
            self._guard.log(fault, (key, cause or fault))
        self._guard.faults.set(key, fault)


def failing(agent: Agent) -> str:
    """Return which features the domain's code fails to read, and why; empty: none."""
    raised = agent.context.feature_cache.failing().items()
    told = each_once((str(use), what_went_wrong(error)) for use, error in raised)
    way_out = "correct the domain and start the agent again"
    return f"cannot read {'; '.join(told)}; {way_out}" if told else ""


def _action(values: Sequence[float], say: str) -> Action:
    """Return a body's action and message, in the types that messages need.

    Raises:
        HitabError: if it is not numbers and a text.
    """
    try:
        if isinstance(say, str):
            return array("d", values), say
    except TypeError:
        pass
    raise HitabError(
        f"act() of its body returned {(values, say)!r}; "
        "it must return numbers and a text to say, empty for nothing"
    )
