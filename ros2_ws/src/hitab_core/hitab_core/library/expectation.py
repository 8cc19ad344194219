"""An expectation that a behavior carries: in this situation, this decision."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from hitab_core.automaton import START, Automaton
from hitab_core.example import Example

KEY = "expectations"
"""Key of the expectations in the optional section of a behavior file."""


@dataclass(frozen=True)
class Expectation:
    """Required decision in a situation.

    Attributes:
        name: unique in the behavior.
        state: state in which the automaton is, or ``Start``.
        features: the situation, by feature, in the units of the domain.
        next_state: label of the required next state.
        blocks: whether a version that breaks it cannot be saved.
        line: line of the file; 0 without a line.
    """

    name: str
    state: str
    features: Mapping[str, float]
    next_state: str
    blocks: bool = False
    line: int = 0

    @classmethod
    def of_example(cls, name: str, example: Example, automaton: Automaton) -> Expectation:
        """Return the expectation that an example's decision is made again."""
        values = zip(automaton.feature_labels, example.features, strict=True)
        known = {feature: value for feature, value in values if value == value}
        return cls(name, example.state, known, example.next_state)

    def broken(self, automaton: Automaton) -> str:
        """Return the differing decision of an automaton, in words; "" if it is as expected.

        Examples:
            >>> from hitab_core import HandWritten, Term
            >>> walk = HandWritten(lambda ahead: "Stop" if ahead < 1.0 else "Go", (0,))
            >>> states, features = (Term("Go"), Term("Stop")), (Term("Ahead"),)
            >>> patrol = Automaton("Patrol", states, features, {"Go": walk})
            >>> Expectation("wall", "Go", {"Ahead": 0.5}, "Stop").broken(patrol)
            ''
            >>> Expectation("wall", "Go", {"Ahead": 1.5}, "Stop").broken(patrol)
            'expectation "wall": in Go it decides Go, not Stop'
        """
        decided = self._decided(automaton)
        if decided == self.next_state:
            return ""
        return f'expectation "{self.name}": in {self.state} it decides {decided}' + (
            f", not {self.next_state}"
        )

    def _decided(self, automaton: Automaton) -> str:
        """Return the decision, or the reason why there is none."""
        function = automaton.transitions.get(self.state)
        if self.state not in (START, *automaton.labels):
            return "nothing, since it has no such state"
        if function is None:
            return "nothing" if self.state == START else self.state
        names = automaton.feature_labels
        for unknown in (names[i] for i in function.features_used if names[i] not in self.features):
            return f"by {unknown}, of which the expectation says nothing"
        values = [self.features.get(name, float("nan")) for name in names]
        if any(value != value for value in values):  # which nothing depends on
            values = [0.0 if value != value else value for value in values]
        odds = function.explain(values, names).distribution
        most = max(odds.values())
        likely = [label for label, p in odds.items() if p == most]
        return likely[0] if len(likely) == 1 else f"by chance among {', '.join(sorted(likely))}"


def broken_expectations(
    expectations: Iterable[Expectation], automaton: Automaton, file: str = ""
) -> list[str]:
    """Return the expectations that an automaton breaks, with its actual decisions.

    Args:
        expectations: expectations to check.
        automaton: the automaton that decides.
        file: the name of the file that has them; empty if they are named without their lines.
    """
    return [
        f"{file}:{one.line}: {text}" if file and one.line else text
        for one in expectations
        if (text := one.broken(automaton))
    ]
