"""Differences between two versions of a behavior, for people to read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from hitab_core.automaton import START
from hitab_core.example import Example
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.library.behavior_file import BehaviorFile


@dataclass(frozen=True, slots=True)
class Difference:
    """What only one of two versions has.

    Attributes:
        added, removed: states, features, parameters and other contents, by name, such as
            ``state GetOpen``.
        added_examples, removed_examples: examples, as text.
        added_rules, removed_rules: rules of the transition functions, as text, such as
            ``GetOpen: if IWasYelledAt: ControlBall``.
    """

    added: tuple[str, ...] = ()
    removed: tuple[str, ...] = ()
    added_examples: tuple[str, ...] = ()
    removed_examples: tuple[str, ...] = ()
    added_rules: tuple[str, ...] = ()
    removed_rules: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        """Return whether the versions differ."""
        return self != Difference()

    def __str__(self) -> str:
        """Return one line per difference: ``-`` before removals, ``+`` before additions."""
        lines = []
        for title, removed, added in (
            ("", self.removed, self.added),
            ("rules:", self.removed_rules, self.added_rules),
            ("examples:", self.removed_examples, self.added_examples),
        ):
            if title and (removed or added):
                lines.append(title)
            lines += [f"- {line}" for line in removed]
            lines += [f"+ {line}" for line in added]
        return "\n".join(lines) or "no difference"


def difference(before: BehaviorFile, after: BehaviorFile) -> Difference:
    """Return the differences between two versions of a behavior.

    Example numbers and recording times are ignored.
    """
    removed, added = _only(_facts(before), _facts(after))
    removed_examples, added_examples = _only(_examples(before), _examples(after))
    removed_rules, added_rules = _only(_rules(before), _rules(after))
    return Difference(added, removed, added_examples, removed_examples, added_rules, removed_rules)


def _only(before: Sequence[str], after: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the multiset differences of two sequences, in both directions."""
    gone, new = Counter(before) - Counter(after), Counter(after) - Counter(before)
    return tuple(gone.elements()), tuple(new.elements())


def _facts(file: BehaviorFile) -> list[str]:
    automaton = file.automaton
    return [
        f"name {automaton.name}",
        f"description {automaton.description}",
        f"classifier {file.classifier}",
        *(f"parameter {parameter}" for parameter in automaton.parameters),
        *(f"state {state}" for state in automaton.states),
        *(f"feature {feature}" for feature in automaton.features),
    ]


def _examples(file: BehaviorFile) -> list[str]:
    names = [str(feature) for feature in file.automaton.features]
    return [_as_text(example, names) for example in file.automaton.examples]


def _as_text(example: Example, names: Sequence[str]) -> str:
    # By name, so that examples compare equal after another feature was trimmed.
    seen = ", ".join(
        f"{name} {value!r}" for name, value in zip(names, example.features, strict=True)
    )
    return f"{example.state} -> {example.next_state} ({example.kind}) {seen}".rstrip()


def _rules(file: BehaviorFile) -> list[str]:
    names = [str(feature) for feature in file.automaton.features]
    rules = []
    for label in (START, *file.automaton.labels):
        function = file.automaton.transitions.get(label)
        if isinstance(function, TransitionTree):
            for rule in function.rules(names):
                words, _, _ = str(rule).rpartition(" (")  # without the number of examples
                rules.append(f"{label}: {words}")
    return rules
