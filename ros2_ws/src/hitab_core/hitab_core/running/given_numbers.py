"""The numbers, such as a speed, with which an automaton's states perform their behaviors."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from hitab_core.running.running_basic import RunningWithNumbers
from hitab_core.transition_function import NumberFunction


@dataclass(slots=True)
class NumberRange:
    """Range around the shown moments in which numbers are taken from them.

    Attributes:
        max_distance: maximum distance, in usual differences; beyond it, a state that takes numbers
            does nothing.
        reason: why such a state did nothing in this tick, or empty.
    """

    max_distance: float = math.inf
    reason: str = ""


class GivenNumbers:
    """Gives the active state of an automaton its numbers, which follow from the features.

    Args:
        number_range: range around the moments shown in which there are numbers.

    Attributes:
        functions: functions of the states that take numbers, by label.
    """

    def __init__(self, number_range: NumberRange) -> None:
        self.functions: Mapping[str, NumberFunction] = {}
        self._range = number_range

    def give(
        self, automaton: str, state: str, child: object, read: Callable[[], list[float]]
    ) -> None:
        """Continue a state with the present numbers, or halt it outside of the range.

        Args:
            automaton, state: labels of the automaton and its active state.
            child: behavior of the state.
            read: function that returns the values of the automaton's features.
        """
        function = self.functions.get(state)
        if function is None or not isinstance(child, RunningWithNumbers):
            return
        values, reach = read(), self._range
        if reach.max_distance < math.inf:
            away = function.distance(values)
            if away > reach.max_distance:
                reach.reason = (
                    f"{automaton} in {state}: it is {away:.2g} spreads from the nearest moment "
                    "whose numbers were shown"
                )
                child.halt()
                return
        child.give(function(values))
