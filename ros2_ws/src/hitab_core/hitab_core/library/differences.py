"""Differences between two versions of a behavior, for people to read."""

from __future__ import annotations

from collections import Counter
from functools import partial

from hitab_core.advice.evidence import Evidence
from hitab_core.advice.situation_text import situation_in_words
from hitab_core.automaton import Automaton
from hitab_core.domain import Domain
from hitab_core.learning.transition_learning import rules_of
from hitab_core.library.behavior_file import BehaviorFile


def difference(before: BehaviorFile, after: BehaviorFile, domain: Domain) -> str:
    """Return the differences between two versions of a behavior, as text.

    Each is a line that begins with ``-`` if only the first version has it, or ``+`` if only the
    second one has it: states and the like, rules, examples. Example numbers and recording times
    are ignored.
    """
    lines = []
    examples = partial(_examples, domain=domain)
    for title, parts in (("", _facts), ("rules:", _rules), ("examples:", examples)):
        one, other = Counter(parts(before)), Counter(parts(after))
        changes = [f"- {text}" for text in (one - other).elements()]
        changes += [f"+ {text}" for text in (other - one).elements()]
        if title and changes:
            lines.append(title)
        lines += changes
    same = _values(before) == _values(after)
    return "\n".join(lines) or ("no difference" if same else "less difference than is shown")


def _values(file: BehaviorFile) -> Counter[tuple[str, str, tuple[float, ...]]]:
    return Counter((e.state, e.next_state, e.features) for e in file.automaton.examples)


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


def _examples(file: BehaviorFile, domain: Domain) -> list[str]:
    uses = file.automaton.features
    units = [domain.feature(term.name).unit for term in uses]
    scales = tuple(map(domain.scale_of, uses))
    # By name, so that examples compare equal after another feature was trimmed.
    evidence = Evidence.of("", (), scales, list(map(str, uses)), units)
    found = []
    for example in file.automaton.examples:
        seen = situation_in_words(evidence, example.features, range(len(uses)))
        text = f"{example.state} -> {example.next_state} ({example.kind.shown}) {seen}"
        found.append(text.rstrip())
    return found


def _rules(file: BehaviorFile) -> list[str]:
    return rules_in_words(file.automaton)


def rules_in_words(automaton: Automaton) -> list[str]:
    """Return the rules of all states, without the numbers of examples."""
    return [
        f"{state}: {str(rule).rpartition(' (')[0]}"
        for state, rules in rules_of(automaton).items()
        for rule in rules
    ]
