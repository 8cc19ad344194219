"""Observers of an agent, which cannot affect it.

An observer is called during a tick with a record of the decision and its feature values. It
cannot read more, draw random numbers or change a state, and its exceptions do not propagate
(`guest`).
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, ParamSpec, TypeVar

from hitab_core.term import Term
from hitab_core.transition_function import Explanation, TransitionFunction

P = ParamSpec("P")
T = TypeVar("T")

_LOG = logging.getLogger(__name__)


class Change(NamedTuple):
    """A change of state as decided; creating one reads no features.

    Attributes:
        automata: labels of the automata, from the top level to the changing automaton.
        source, destination: labels of the states.
        commanded: whether by the demonstrator rather than by a transition function.
        terms: the automaton's features, in its own terms.
        bindings: bindings of its parameters to targets.
        values: value of each feature; None if not read in this tick, NaN if missing. Empty if
            commanded.
        function: transition function that decided; None if commanded.
    """

    automata: Sequence[str]
    source: str
    destination: str
    commanded: bool
    terms: Sequence[Term] = ()
    bindings: Mapping[str, str] | None = None
    values: Sequence[float | None] = ()
    function: TransitionFunction | None = None

    @property
    def features(self) -> list[str]:
        """The automaton's features, bound to targets."""
        return [str(term.bound(self.bindings or {})) for term in self.terms]

    def explanation(self) -> Explanation | None:
        """Return why, from the values that the decision read; None if commanded."""
        if self.function is None:
            return None
        return self.function.retrace(self.values, self.features)


Observe = Callable[[Change], None]
"""Called at each change of state, after the decision and before the new state is started."""


def guest(observe: Callable[P, T]) -> Callable[P, T | None]:
    """Return an observer that calls ``observe`` and never raises; then it returns None.

    An exception of an observer is logged, but not the same one twice in a row.
    """
    if hasattr(observe, "is_guest"):
        return observe
    last = ""

    def look(*args: P.args, **kwargs: P.kwargs) -> T | None:
        nonlocal last
        try:
            return observe(*args, **kwargs)
        except Exception as error:
            if (why := repr(error)) != last:
                last = why
                _LOG.warning("an observer failed; the agent continues: %s", why, exc_info=error)
            return None

    look.is_guest = True  # type: ignore[attr-defined]
    return look
