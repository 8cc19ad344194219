"""Contradictions among examples, and the effect of a change of examples or features."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hitab_client import Learned
from hitab_core import Example, contradictions
from hitab_core.library import rules_in_words


def is_contradicted(examples: Sequence[Example]) -> dict[int, list[int]]:
    """Return the contradicted examples, each with the numbers of the contradicting ones.

    Two examples contradict each other if their states and values are equal but their next states
    differ.
    """
    return {
        example.number: [e.number for e in group if e.next_state != example.next_state]
        for group in contradictions(examples)
        for example in group
    }


def superseding(examples: Sequence[Example]) -> dict[int, list[int]]:
    """Return the superseded examples, each with the numbers of the superseding ones."""
    return {
        example.number: [e.number for e in examples if e.leaves and e.place == example.place]
        for example in examples
        if not example.is_learned
    }


@dataclass(frozen=True)
class Effect:
    """The effect of a change of examples.

    Attributes:
        rules_gone, rules_new: removed and added rules of the trees, as text.
        decisions: the examples with a changed decision, each with the former and the new one.
    """

    rules_gone: tuple[str, ...]
    rules_new: tuple[str, ...]
    decisions: tuple[tuple[Example, str, str], ...]


def effect(before: Learned, after: Learned) -> Effect:
    """Compare a behavior before and after a change of the examples or of the features."""
    old, new = rules_in_words(before), rules_in_words(after)
    former = {e.number: e for e in before.examples}
    decisions = []
    for example in after.examples:
        # The former decision in the example's situation uses the former features.
        then = example if before.features == after.features else former.get(example.number)
        if then is None or not example.is_learned:
            continue
        was = most_probable(before.decides(then.state, then.features))
        now = most_probable(after.decides(example.state, example.features))
        if was and was != now:
            decisions.append((example, was, now))
    return Effect(
        tuple(r for r in old if r not in new),
        tuple(r for r in new if r not in old),
        tuple(decisions),
    )


def most_probable(distribution: Mapping[str, float]) -> str:
    """Return the most probable state; "" if the distribution is empty."""
    return max(distribution, key=lambda s: distribution[s]) if distribution else ""
