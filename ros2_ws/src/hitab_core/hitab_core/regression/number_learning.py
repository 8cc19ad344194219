"""Learns the numbers of each state from the moments in which it was commanded."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from hitab_core.domain import Scale
from hitab_core.example import Example
from hitab_core.number import Number
from hitab_core.regression.neighbors import Neighbors
from hitab_core.use import Use


def learn_numbers(
    states: Iterable[Use],
    scales: Sequence[Scale],
    examples: Iterable[Example],
    numbers_of: Callable[[Use], Sequence[Number]],
) -> dict[str, Neighbors]:
    """Return what gives the numbers of each state whose behavior takes some, by label.

    A state learns from all commands of it, whatever state they left. Without one that gave
    numbers, nothing is learned for it.

    Args:
        states: of the automaton.
        scales: how the values of each feature compare.
        examples: with one value per feature.
        numbers_of: returns the numbers that the behavior of a state takes.
    """
    learned = {}
    shown = [example for example in examples if example.numbers]
    for state in states:
        if wanted := numbers_of(state):
            own = [example for example in shown if example.next_state == str(state)]
            if own:
                values = [example.features for example in own]
                numbers = [example.numbers for example in own]
                learned[str(state)] = Neighbors(
                    values, numbers, scales, wanted, [e.number for e in own]
                )
    return learned
