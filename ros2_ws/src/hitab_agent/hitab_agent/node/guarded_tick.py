"""The guarded tick: an agent that cannot act does nothing and reports why.

An agent that decides without the value of some feature acts, and reports the feature.
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
"""The fault of an agent whose domain raises an exception when it reads features."""


class GuardedTick:
    """Ticks an agent; its methods never raise.

    Attributes:
        fault: why the agent does nothing; empty if nothing is wrong.
    """

    def __init__(self, agent: Agent, guard: Guard) -> None:
        """Prepare to tick.

        Args:
            agent: the agent to tick.
            guard: the guard of the agent's node, which shows the faults.
        """
        self.fault = ""
        self._failed_in = ("", "")
        self._agent = agent
        self._features = agent.context.feature_cache
        self._guard = guard
        self._faults = guard.faults

    def perceived(self) -> None:
        """Report features that cannot be read, whether decisions need them or not."""
        # The first percept has shown for most agents that all can be read.
        if self._features.failed == {} and not self._faults.by_key:
            return
        if (why := failing(self._agent)) or self._faults.by_key:
            self._show(FEATURES_FAULT, why)

    def act(self) -> Action:
        """Make the agent decide and act; return its action and message, or nothing if it fails."""
        agent = self._agent
        try:
            agent.tick()
            action = _action(*agent.body.act())
        except Exception as error:
            self.fail(error)
            return NO_ACTION
        self.fault = ""
        if self._features.missed or self._faults.by_key:
            lacking = self._features.lacking()
            if lacking:
                self._failed_in = self._doing
            self._show(TICK, "")
            why = f"{agent.name} decides without needed values: {'; '.join(lacking)}"
            self._show(VALUES, why if lacking else "")
        return action

    def fail(self, error: Exception) -> None:
        """Report an error that kept the agent from perceiving, deciding or acting."""
        agent, why = self._agent, what_went_wrong(error)
        self._failed_in = self._doing
        if why != self.fault:
            self.fault = why
            fault = f"{agent.name} has done nothing since cycle {agent.cycle}: {why}"
            self._show(TICK, fault, cause=why)

    def clear_if_past(self) -> None:
        """Clear the faults if the agent no longer performs the behavior that caused them."""
        if self._failed_in != self._doing:
            self.fault = ""
            self._show(TICK, "")
            if self._guard.faults.text(VALUES):
                self._features.missed.clear()
                self._show(VALUES, "")

    @property
    def _doing(self) -> tuple[str, str]:
        return self._agent.mode.value, self._agent.behavior

    def _show(self, key: str, fault: str, cause: str = "") -> None:
        if fault:
            self._guard.log(fault, (key, cause or fault))
        self._guard.faults.set(key, fault)


def failing(agent: Agent) -> str:
    """Return which features the domain fails to read, and why; empty if it reads all."""
    raised = agent.context.feature_cache.failing()
    if not raised:
        return ""
    failures = each_once((str(term), what_went_wrong(error)) for term, error in raised.items())
    return f"cannot read {'; '.join(failures)}; correct the domain and start the agent again"


def _action(values: Sequence[float], say: str) -> Action:
    """Return a body's action and message, in the types that messages need.

    Raises:
        HitabError: if the action is no list of numbers, or the message no text.
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
