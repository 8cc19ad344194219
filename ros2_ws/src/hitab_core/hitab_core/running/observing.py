"""What those who watch an agent see of it, so that watching changes nothing.

An observer is a guest of the tick. It gets a record of what was decided, with the values that the
decision had read, and nothing by which it could read more, draw, or change a state; and whatever
it raises ends with it (`guest`).
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import ParamSpec, cast

from hitab_core.transition_function import Explanation, TransitionFunction
from hitab_core.use import Use

P = ParamSpec("P")

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Change:
    """A change of state, as it was decided; making one reads nothing.

    Attributes:
        automata: labels of the automata, from the top-level behavior's to the one that changes.
        source, destination: labels of the states.
        commanded: by the demonstrator rather than by a transition function.
        uses: the automaton's features, as it calls them.
        bindings: what its parameters are bound to.
        values: of each feature; None where it had not been read in this tick. Empty if commanded.
        function: what decided; None if commanded.
    """

    automata: Sequence[str]
    source: str
    destination: str
    commanded: bool
    uses: Sequence[Use] = ()
    bindings: Mapping[str, str] | None = None
    values: Sequence[float | None] = ()
    function: TransitionFunction | None = None

    @property
    def features(self) -> list[str]:
        """The automaton's features, bound to targets."""
        return [str(use.bound(self.bindings or {})) for use in self.uses]

    def explanation(self) -> Explanation | None:
        """Return why, by the values that the decision had read; None if it was commanded."""
        if self.function is None:
            return None
        return self.function.retrace(self.values, self.features)


Observe = Callable[[Change], None]
"""Called at each change of state, after the decision and before the new state is started."""


class _Guest:
    """Calls an observer; logs what it raises, the same error once in a row."""

    __slots__ = ("_last", "_observe")

    def __init__(self, observe: Callable[..., None]) -> None:
        self._observe = observe
        self._last = ""

    def __call__(self, *seen: object) -> None:
        try:
            self._observe(*seen)
        except Exception as error:
            if (why := repr(error)) != self._last:
                self._last = why
                _LOG.warning("an observer failed, which changes nothing: %s", why, exc_info=error)


def guest(observe: Callable[P, None]) -> Callable[P, None]:
    """Return an observer that calls ``observe`` and never raises into who calls it."""
    return cast(Callable[P, None], observe if isinstance(observe, _Guest) else _Guest(observe))
