"""Texts of questions to the demonstrator: short sentences in words of the README."""

from __future__ import annotations

from collections.abc import Sequence

from hitab_core.advice.changed import Changed
from hitab_core.advice.evidence import Evidence
from hitab_core.advice.rivals import Rival
from hitab_core.advice.situation_text import situation_in_words
from hitab_core.advice.unshown import Unshown
from hitab_core.assistant.question import Choice
from hitab_core.example import Example
from hitab_core.texts.wording import numbered, quantity, some

VALUES_SHOWN_MAX = 4
"""Maximum number of values named; with more, only values that the decision depends on."""


def commanded(group: Sequence[Example]) -> str:
    """Return a question about commands that contradict each other.

    Examples:
        >>> stop, turn = (Example("Go", (), s, number=n) for n, s in ((3, "Stop"), (5, "Turn")))
        >>> commanded([stop, turn]).partition("situation, ")[2]
        'you commanded Stop (example 3) and Turn (example 5): which holds?'
    """
    by_label: dict[str, list[int]] = {}
    for example in group:
        by_label.setdefault(example.next_state, []).append(example.number)
    said = [f"{label} ({numbered('example', n)})" for label, n in by_label.items()]
    return f"In {group[0].state}, in the same situation, you commanded {_and(said)}: which holds?"


def never_shown(found: Unshown, evidence: Evidence) -> str:
    """Return a question about a situation that was met and never shown."""
    where = situation(evidence, found.situation)
    learned = f"; as it is, {_follows(found.decided, found.state)}" if found.decided else ""
    return f"What is right in {found.state}{where}? Nothing like it was shown{learned}."


def which_feature(found: Rival, evidence: Evidence) -> str:
    """Return a question about a situation in which two explanations of the examples differ."""
    where = situation(evidence, found.situation)
    by, instead = evidence.names[found.feature], some([evidence.names[f] for f in found.instead])
    return (
        f"What is right in {found.state}{where}? By {by}, {_follows(found.decided, found.state)}; "
        f"{instead} would explain your commands as well, and then "
        f"{_follows(found.otherwise, found.state)}."
    )


def ambiguous(example: Example, choices: Sequence[Choice]) -> str:
    """Return a question about a command that may be meant for either of two moments."""
    first, second = (f"{choice.name}, in {choice.state}" for choice in choices)
    return f"When was {example.next_state} due (example {example.number}): {first}, or {second}?"


def due(state: str, ago: float) -> str:
    """Return the effect of an answer that says when a command was due."""
    return f"due {ago:.2f} s before its command, in {state}"


def _follows(decided: str, state: str) -> str:
    return "it stays" if decided == state else f"{decided} follows"


def situation(evidence: Evidence, values: Sequence[float]) -> str:
    """Return a situation in words, such as `` with Range = 2 m``, or nothing."""
    features: Sequence[int] = range(len(values))
    if len(values) > VALUES_SHOWN_MAX:
        tree = evidence.learn()
        features = (
            sorted(tree.features_used)[:VALUES_SHOWN_MAX]
            if tree is not None
            else features[:VALUES_SHOWN_MAX]
        )
    words = situation_in_words(evidence, values, features)
    return f" with {words}" if words else ""


def answered(state: str, next_state: str) -> str:
    """Return the effect of an answer that gives the right decision of a situation."""
    if next_state == state:
        return f"adds an example: stay in {state} there"
    return f"adds an example: go to {next_state} there"


def effect(what: str, changed: Sequence[Changed]) -> str:
    """Return the effect of an answer, with the first changed decision of each state."""
    first: dict[str, str] = {}
    for evidence, values, was, now in changed:
        if (state := evidence.state) not in first:
            first[state] = f"in {state}{situation(evidence, values)}: {now} instead of {was}"
    more = len(changed) - len(first)
    others = [quantity(more, "more such decision")] if more else []
    return "; ".join([what, *(first.values() or ["changes no decision"]), *others])


def _and(texts: Sequence[str]) -> str:
    if len(texts) == 2:
        return " and ".join(texts)
    return some(texts, len(texts))
