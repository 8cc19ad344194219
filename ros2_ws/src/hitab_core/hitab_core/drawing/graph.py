"""The transitions of an automaton as arrows with words: what a text or a picture of it shows."""

from __future__ import annotations

from dataclasses import dataclass

from hitab_core.automaton import FLAGS, START, Automaton
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.transition_function import TransitionFunction

NO_RULES = "a function without rules decides"
"""The condition of an arrow when its transition function has no readable rules."""


@dataclass(frozen=True, slots=True)
class Way:
    """One way to get from a state to another.

    Attributes:
        conditions: all that must hold; none: always.
        probability: of the next state where they hold.
    """

    conditions: tuple[str, ...]
    probability: float = 1.0

    def __str__(self) -> str:
        """Return ``A and B``, with the probability unless it is 1."""
        text = " and ".join(self.conditions) or "always"
        return text if self.probability == 1.0 else f"{text} ({self.probability:.2g})"


@dataclass(frozen=True, slots=True)
class Arrow:
    """From a state to another, or itself, in one of several ways; no ways: no readable rules."""

    source: str
    target: str
    ways: tuple[Way, ...]

    @property
    def is_loop(self) -> bool:
        """Whether the arrow leads back to its own state."""
        return self.source == self.target

    @property
    def leaves_flag(self) -> bool:
        """Whether it leads from a flag state back to Start, as it always does."""
        return self.source in FLAGS and self.target == START


def arrows(automaton: Automaton) -> list[Arrow]:
    """Return an automaton's transitions, by source and then target, both in the states' order."""
    order = [START, *automaton.labels]
    found = []
    for source in order:
        if source in FLAGS:
            found.append(Arrow(source, START, (Way(()),)))
        elif source in automaton.transitions:
            ways = _ways(automaton.transitions[source], automaton)
            found += [Arrow(source, t, tuple(ways[t])) for t in order if t in ways]
    return found


def _ways(function: TransitionFunction, automaton: Automaton) -> dict[str, list[Way]]:
    ways: dict[str, list[Way]] = {}
    if isinstance(function, TransitionTree):
        for rule in function.rules(automaton.feature_labels):
            for label, probability in rule.distribution.items():
                ways.setdefault(label, []).append(Way(rule.conditions, probability))
    else:
        for label in getattr(function, "labels", ()):
            ways[label] = []
    return ways
